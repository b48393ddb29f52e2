"""The sections of a report, one function each, in the order in which they are read."""

import numpy as np
from markupsafe import Markup

from ...fit.agreement import Agreement
from ...fit.fit import Fit
from ...fit.verdict import gains_estimated, gains_sentence, verdict
from ..report_html import figure, grid, heading, listing, number, paragraph, section
from ..svg import COLUMNS
from .friction_curve import ROOM_TEMPERATURE
from .report_plots import STRETCH, friction_plot, measured_unit, torque_plot
from .report_tables import (
    correlation_table,
    dropped_table,
    filter_table,
    gain_table,
    joint_table,
    moved_table,
    parameter_tables,
    runs_table,
    unclear_table,
)

STRETCHES = 20_000
"""Stretches of lines in all plots of runs together; each costs some 33 bytes, so all cost 0.7 MB."""
NO_SAMPLES = (
    "This fit was loaded without the samples of its runs, so that there is nothing to draw here. "
    "Identify again from the recordings to see it."
)


def verdict_section(fit: Fit) -> str:
    """What to think of the fit, before any detail."""
    return section("verdict", "Verdict", listing(verdict(fit), "verdict"), joint_table(fit))


def gains_section(fit: Fit) -> str:
    """Drive gains."""
    note = (
        "Torque per motor current, signed. Grey: the nominal value with its 95 % interval; blue: the "
        "estimate with its interval, on the scale of the nominal value's deviation; an arrow points to what "
        "lies outside."
    )
    if not gains_estimated(fit):
        note = gains_sentence(fit)
        if fit.unscaled or fit.measures == "torque":
            return section("gains", "Drive gains", paragraph(note))
    return section("gains", "Drive gains", paragraph(note), gain_table(fit))


def parameters_section(fit: Fit) -> str:
    """Base parameters with intervals against priors."""
    note = (
        f"Base parameters by {fit.estimate.method}, in SI units. R marks one into which others are "
        "regrouped. Grey: the nominal value with its 95 % interval; blue: the estimate with its interval; "
        "the line in the middle is the nominal value, and the width is nine of its deviations."
    )
    content = [paragraph(note), parameter_tables(fit)]
    if fit.unclear:
        content += [heading("Unclear"), unclear_table(fit)]
    if fit.moved:
        note = "No arm can have these values: export and simulation take the nearest that one can have."
        content += [heading("Exported otherwise"), paragraph(note), moved_table(fit)]
    return section("parameters", "Parameters", *content)


def runs_section(fit: Fit) -> str:
    """Measured, predicted and residual torque of every run and joint."""
    runs = [(run, "held out") for run in fit.validation] + [(run, "used") for run in fit.agreement]
    runs += [(run, "not judged") for run in fit.apart]
    if not runs:
        return section("runs", "Runs", paragraph(NO_SAMPLES), runs_table(fit) if fit.scores else "")
    plots = len(runs) * fit.model.robot.dof
    columns = int(np.clip(STRETCHES // plots, 40, COLUMNS))
    note = (
        "The table has, for each run and joint, residual over noise and residual in per cent of the "
        "torque. In the plots measured and predicted torque lie on one another; samples in which the "
        "joint stands still are not judged, and residuals there may leave the frame. Of runs above "
        f"{STRETCH:g}\u00a0s the torque is shown where most of the residual lies."
    )
    content = [_run(fit, run, role, columns) for run, role in runs]
    return section("runs", "Runs", paragraph(note), runs_table(fit), *content)


def _run(fit: Fit, run: Agreement, role: str, columns: int) -> str:
    figures = [
        figure(
            joint,
            f"residual {run.residual_rms[j]:.3g} {measured_unit(fit, j)}, "
            f"{run.over_noise[j]:.2f} x noise, {100 * run.relative[j]:.2g} % of the torque",
            torque_plot(run, fit.model.robot, j, columns, measured_unit(fit, j)),
        )
        for j, joint in enumerate(fit.model.robot.joints)
    ]
    return heading(f"{run.run} ({role})") + grid(*figures, kind="two alike")


def friction_section(fit: Fit) -> str:
    """Friction of every joint over its velocity."""
    note = (
        "Friction is what sliding adds to the torque that does not pass the gear. Dots: measured torque of "
        "the runs used, everything else taken off; where they leave the curve together, the form of the "
        "friction is wrong. What depends on more than velocity is drawn at mid-range and "
        f"{ROOM_TEMPERATURE:g}\u00a0\u00b0C."
    )
    figures = [figure(joint, "", friction_plot(fit, j)) for j, joint in enumerate(fit.model.robot.joints)]
    without = "" if fit.agreement else paragraph(NO_SAMPLES)
    return section("friction", "Friction", paragraph(note), without, grid(*figures, kind="three alike"))


def conditioning_section(fit: Fit) -> str:
    """How well the data distinguish the parameters."""
    words = Markup(
        "<p>Condition number of the weighted regressor with unit columns: {}. "
        "It is the ratio of the most visible combination of parameters to the least visible "
        "one. Below are the estimates that the data distinguish worst; near \u22121 or 1 only their sum or "
        "difference is known.</p>"
    ).format(number(fit.condition, 3))
    return section("conditioning", "Conditioning", words, correlation_table(fit))


def structure_section(fit: Fit) -> str:
    """What was regrouped, dropped, or cannot be seen at all."""
    halves = []
    if fit.base.expressions:
        rows = Markup().join(Markup("<li><code>{}</code></li>").format(e) for e in fit.base.expressions)
        halves.append(heading("Regrouped") + Markup("<ul>{}</ul>").format(rows))
    if fit.dropped:
        words = "The data do not support these; they were set to zero and the others estimated again."
        halves.append(heading("Dropped") + paragraph(words) + dropped_table(fit))
    content = [grid(*(Markup("<div>{}</div>").format(half) for half in halves), kind="two tables")]
    if hidden := (fit.structure or fit.base).without_effect:
        words = f"No motion of this arm makes them felt in a torque: {', '.join(hidden)}."
        content += [heading("Without effect"), paragraph(words)]
    return section("structure", "Regrouped and dropped", *content)


def data_section(fit: Fit) -> str:
    """Runs, filters and warnings."""
    held_out = ", ".join(run.run for run in fit.validation) or "none"
    runs = f"Identified from {', '.join(fit.runs)}; held out: {held_out}."
    warnings = listing(fit.warnings) if fit.warnings else paragraph("The recordings gave no warnings.")
    return section(
        "data", "Data, filters, warnings", paragraph(runs), filter_table(fit), heading("Warnings"), warnings
    )


SECTIONS = (
    verdict_section,
    gains_section,
    parameters_section,
    runs_section,
    friction_section,
    conditioning_section,
    structure_section,
    data_section,
)
