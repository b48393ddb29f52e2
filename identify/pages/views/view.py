"""View: a fit as a Rerun recording.

Every run has its own tab with one plot a joint, the arm as it moved, and all residuals over their noise;
beside them stand the verdict, the parameters as a table, and their intervals as a bar chart.
"""

import subprocess
from functools import partial
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ...arm.robot import Robot
from ...fit.fit import Agreement, Fit
from ...fit.warnings.verdict import NORMAL_95
from ..fit.report_plots import measured_unit
from .view_arm import arm_view, log_arm
from .view_parts import JOINTS, TIMELINE, WHITE, open_viewer, send
from .view_text import parameters_markdown, verdict_markdown

LINES = {"measured": (3.5, 230, 159, 0), "predicted": (1.2, 86, 180, 233), "residual": (1.0, 213, 94, 0)}
"""Width in pixels and colour of each line: Okabe and Ito's, on Rerun's dark ground."""
CAPPED = 100.0
"""Per cent at which a bar ends: beyond it not even the sign is known, and others would look like none."""


def save_rerun(fit: Fit, path: Path) -> None:
    """Save measured, predicted and residual torque, parameters and the moving arm as an .rrd file."""
    recording = rr.RecordingStream("exidyn_fit")
    recording.save(str(path), default_blueprint=blueprint(fit))
    log_fit(recording, fit)
    recording.disconnect()  # writes the footer, without which readers complain


def open_rerun(fit: Fit) -> "subprocess.Popen[bytes]":
    """Show a fit in Rerun's viewer, which lives on after this process."""
    return open_viewer(partial(save_rerun, fit), "fit")


def log_fit(recording: rr.RecordingStream, fit: Fit) -> None:
    """Write everything to an open recording."""
    recording.log("verdict", rr.TextDocument(verdict_markdown(fit), media_type="text/markdown"), static=True)
    recording.log(
        "parameters/table", rr.TextDocument(parameters_markdown(fit), media_type="text/markdown"), static=True
    )
    recording.log("parameters/interval", _interval_bars(fit), static=True)
    for run in _runs(fit):
        _log_run(recording, fit.model.robot, run)
        if run.position is not None:
            log_arm(recording, fit.model, _arm_name(run), run.time, run.position)


def blueprint(fit: Fit) -> rrb.Blueprint:
    """One screen: a tab a run on the left, what was found on the right."""
    found = rrb.Vertical(
        rrb.TextDocumentView(origin="verdict", name="verdict"),
        rrb.Tabs(
            rrb.TextDocumentView(origin="parameters/table", name="parameters"),
            rrb.BarChartView(origin="parameters/interval", name="95 % interval [% of value]"),
        ),
        row_shares=[2, 3],
    )
    runs = [_run_tab(fit, run) for run in _runs(fit)]
    layout = rrb.Horizontal(rrb.Tabs(*runs, active_tab=0), found, column_shares=[3, 1]) if runs else found
    panel = rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="paused")
    return rrb.Blueprint(layout, panel, collapse_panels=True)


def _run_tab(fit: Fit, run: Agreement) -> rrb.Container:
    plots = [
        rrb.TimeSeriesView(
            origin=_entity(run, "torque", joint),
            name=f"{joint}: torque [{measured_unit(fit, index)}]",
            plot_legend=rrb.PlotLegend(visible=index == 0),
        )
        for index, joint in enumerate(fit.model.robot.joints)
    ]
    ratio = rrb.TimeSeriesView(origin=_entity(run, "over_noise"), name="residual / noise")
    content = rrb.Grid(*plots, grid_columns=2)
    if run.position is None:
        return rrb.Vertical(content, ratio, row_shares=[3, 1], name=run.run)
    beside = rrb.Vertical(arm_view(fit.model, _arm_name(run)), ratio, row_shares=[3, 2])
    return rrb.Horizontal(content, beside, column_shares=[2, 1], name=run.run)


def _runs(fit: Fit) -> list[Agreement]:
    """Runs held out first: they are the ones that judge."""
    return [*fit.validation, *fit.agreement, *fit.apart]


def _entity(run: Agreement, *parts: str) -> str:
    """Entity path below a run, whose own name may hold any sign."""
    return str(rr.new_entity_path(["runs", run.run, *parts]))


def _arm_name(run: Agreement) -> str:
    """Name of a run's arm: one part of an entity path, and the prefix of its link frames."""
    return f"arm in {run.run}"


def _log_run(recording: rr.RecordingStream, robot: Robot, run: Agreement) -> None:
    for index, joint in enumerate(robot.joints):
        for name, (width, *colour) in LINES.items():
            entity = _entity(run, "torque", joint, name)
            recording.log(entity, rr.SeriesLines(names=name, colors=colour, widths=width), static=True)
            send(recording, entity, run.time, getattr(run, name)[:, index])
    entity = _entity(run, "over_noise")
    colours = [*JOINTS, *[WHITE] * robot.dof][: robot.dof]
    recording.log(entity, rr.SeriesLines(names=list(robot.joints), colors=colours), static=True)
    send(recording, entity, run.time, run.residual / run.noise)


def _interval_bars(fit: Fit) -> rr.BarChart:
    """Half-width of each 95 % interval in per cent of the value, in the order of the table."""
    size = np.maximum(np.abs(fit.estimate.values), np.finfo(float).tiny)
    return rr.BarChart(np.minimum(100.0 * NORMAL_95 * fit.estimate.std / size, CAPPED))
