"""View of a fit: one tab per run with a plot per joint, the moving arm, and residuals over the noise floor.

Beside them are the verdict, a table of parameters, and a bar chart of their intervals.
"""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identification.arm.robot import Robot
from exidyn.identification.document.text import section_markdown
from exidyn.identification.fit.agreement import Agreement
from exidyn.identification.fit.fit import Fit
from exidyn.identification.pages.fit_document import fit_sections
from exidyn.identification.pages.fit_plots import measured_unit
from exidyn.identification.text_table import NORMAL_95

from .parts import Arm, arm_name, arm_view, entity, joint_colors, log_lines, log_markdown, plot, screen
from .viewers import View

LINES = {"measured": (3.5, 230, 159, 0), "predicted": (1.2, 86, 180, 233), "residual": (1.0, 213, 94, 0)}
"""Width in pixels and color of each line, from the palette of Okabe and Ito for a dark background."""
CAPPED = 100.0
"""Maximum length of a bar [%]: beyond it not even the sign is known, and other bars would be too short."""


def fit_view(fit: Fit) -> View:
    """A view of a fit with measured and predicted torques of its runs; without runs, of the arm alone."""
    runs = [*fit.validation, *fit.agreement, *fit.apart]  # held-out runs come first

    def log(stream: rr.RecordingStream) -> None:
        sections = {section.anchor: section_markdown(section) for section in fit_sections(fit)}
        log_markdown(stream, "verdict", sections["verdict"])
        log_markdown(stream, "parameters/table", f"{sections['gains']}\n\n{sections['parameters']}")
        # Half-width of each 95 % interval in percent of the value, in the order of the table.
        size = np.maximum(np.abs(fit.estimate.values), np.finfo(float).tiny)
        halves = np.minimum(100.0 * NORMAL_95 * fit.estimate.std / size, CAPPED)
        stream.log("parameters/interval", rr.BarChart(halves), static=True)
        for run in runs:
            _log_run(stream, fit.model.robot, run)
            if run.position is not None:
                Arm(stream, fit.model, arm_name(run.run)).move(run.time, run.position)
        if not runs:
            Arm(stream, fit.model).move(np.zeros(1), np.zeros((1, fit.model.robot.dof)))

    return View("fit", log, _layout(fit, runs))


def _layout(fit: Fit, runs: list[Agreement]) -> rrb.Blueprint:
    """One tab per run on the left, verdict and parameters on the right."""
    words = rrb.TextDocumentView(origin="verdict", name="verdict")
    parameters = rrb.TextDocumentView(origin="parameters/table", name="parameters")
    intervals = rrb.BarChartView(origin="parameters/interval", name="95 % interval [% of value]")
    if not runs:
        arm = rrb.Vertical(arm_view(fit.model), intervals, row_shares=[3, 2])
        layout = rrb.Horizontal(arm, parameters, words)
        return rrb.Blueprint(layout, rrb.TimePanel(state="hidden"), collapse_panels=True)
    beside = rrb.Vertical(words, rrb.Tabs(parameters, intervals), row_shares=[2, 3])
    tabs = rrb.Tabs(*(_run_tab(fit, run) for run in runs), active_tab=0)
    return screen(rrb.Horizontal(tabs, beside, column_shares=[3, 1]))


def _run_tab(fit: Fit, run: Agreement) -> rrb.Container:
    plots = [
        plot(_entity(run, "torque", joint), f"{joint}: torque [{measured_unit(fit, index)}]", index == 0)
        for index, joint in enumerate(fit.model.robot.joints)
    ]
    ratio = plot(_entity(run, "over_noise"), "residual / noise", legend=True)
    content = rrb.Grid(*plots, grid_columns=2)
    if run.position is None:
        return rrb.Vertical(content, ratio, row_shares=[3, 1], name=run.run)
    beside = rrb.Vertical(arm_view(fit.model, arm_name(run.run)), ratio, row_shares=[3, 2])
    return rrb.Horizontal(content, beside, column_shares=[2, 1], name=run.run)


def _entity(run: Agreement, *parts: str) -> str:
    """Entity path below a run."""
    return entity("runs", run.run, *parts)


def _log_run(stream: rr.RecordingStream, robot: Robot, run: Agreement) -> None:
    for index, joint in enumerate(robot.joints):
        for name, (width, *color) in LINES.items():
            path, values = _entity(run, "torque", joint, name), getattr(run, name)[:, index]
            log_lines(stream, path, [name], [tuple(color)], run.time, values, width)
    ratio = run.residual / run.noise
    log_lines(stream, _entity(run, "over_noise"), robot.joints, joint_colors(robot.dof), run.time, ratio)
