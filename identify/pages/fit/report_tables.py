"""The tables of a report."""

from collections.abc import Collection

import numpy as np
from markupsafe import Markup

from ...fit.agreement import Agreement, Scores
from ...fit.fit import Fit
from ...fit.verdict import (
    EXPLAINED,
    LITTLE,
    NORMAL_95,
    NOT_FOUND,
    UNJUDGED,
    gains_estimated,
    joint_verdicts,
    judged,
)
from ..report_html import NAMELESS, grid, number, table, unit
from .report_plots import interval_bar, measured_unit

KINDS = {EXPLAINED: "good", LITTLE: "middling", NOT_FOUND: "middling", UNJUDGED: "middling"}
"""Words about a joint -> how they are coloured, red if not here."""
WORST_PAIRS = 12
"""Pairs of correlated parameters that are listed."""


def joint_table(fit: Fit, missing: Collection[str] | None = None) -> str:
    """One line a joint: how well it is explained where it is explained worst; `missing` as of `verdict`."""
    runs = {run.run: run for run in judged(fit)}
    rows = []
    for joint, found in enumerate(joint_verdicts(fit, missing)):
        run = runs[found.run]
        kind = KINDS.get(found.words, "bad")
        words = found.words.partition(":")[0]  # the verdict has the reason once, for all joints
        numbers = (found.over_noise, run.residual_rms[joint], run.noise[joint], 100 * run.relative[joint])
        cells = [number(value, 3) for value in numbers]
        rows.append(
            [
                found.joint, Markup('<td class="words {}">{}</td>').format(kind, words), *cells,
                number(run.r_squared[joint], 5), measured_unit(fit, joint), run.run,
            ]
        )  # fmt: skip
    head = [
        "joint",
        "verdict",
        "residual / noise",
        "residual rms",
        "noise",
        "residual, % of torque",
        "R\u00b2",
    ]
    return table([*head, "unit", "worst run"], rows, words=(1, 7, 8)) if rows else ""


def runs_table(fit: Fit) -> str:
    """Residual over noise of every run and joint."""
    rows = [_run_row(run, "used") for run in fit.agreement]
    rows += [_run_row(run, "held out") for run in fit.validation]
    rows += [_run_row(run, "not judged") for run in fit.apart]
    rows = rows or [_run_row(run, "held out" if run.held_out else "used") for run in fit.scores]
    return table(["run", "role", *fit.model.robot.joints], rows, words=(1,))


def _run_row(run: Agreement | Scores, role: str) -> list[str]:
    pairs = zip(run.over_noise, 100 * run.relative, strict=True)
    return [run.run, role, *(number(over, 3) + "; " + number(share, 2) + " %" for over, share in pairs)]


def gain_table(fit: Fit) -> str:
    """Drive gains with 95 % intervals beside the nominal ones."""
    robot, estimate = fit.model.robot, fit.estimate
    found = gains_estimated(fit)
    rows = []
    for joint, name in enumerate(robot.joints):
        gain, std, prior = estimate.gain[joint], estimate.gain_std[joint], robot.drive_gain[joint]
        tolerance = robot.drive_gain_tolerance[joint] * abs(prior)
        cells = [number(gain, 5), f"{robot.units('N m')[joint]}/A"]
        cells += [number(NORMAL_95 * std, 3), number(100 * std / abs(gain), 2)] if found else [NAMELESS] * 2
        if fit.gains_unstated:  # a gain of 1 was never stated
            rows.append([name, *cells, NAMELESS, NAMELESS, NAMELESS])
            continue
        cells += [number(prior), number(tolerance, 2)]
        rows.append([name, *cells, interval_bar(gain, std, prior, tolerance) if found else "nominal"])
    return table(
        ["joint", "gain", "unit", "\u00b1 95 %", "std %", "nominal", "\u00b1 std", "against nominal"],
        rows,
        (2, 7),
    )


def parameter_rows(fit: Fit) -> list[list[str]]:
    """One row a base parameter."""
    estimate, (nominal, deviation) = fit.estimate, fit.prior
    if fit.unscaled:  # values in amperes compare with no prior
        deviation = np.full(len(deviation), np.inf)
    rows = []
    for k, (name, measure) in enumerate(zip(fit.names, fit.base.units, strict=True)):
        value, std = estimate.values[k], estimate.std[k]
        percent = 100 * float(std) / abs(float(value)) if value else np.inf
        stated = np.isfinite(deviation[k])
        rows.append(
            [
                name, number(value), unit(measure), number(NORMAL_95 * std, 2), number(percent, 2),
                number(nominal[k]) if stated else NAMELESS, number(deviation[k], 2),
                interval_bar(value, std, nominal[k], deviation[k]),
            ]
        )  # fmt: skip
    return rows


def parameter_tables(fit: Fit) -> str:
    """Base parameters, in two tables side by side where the screen is wide."""
    rows = parameter_rows(fit)
    half = (len(rows) + 1) // 2
    per = ", ".join(dict.fromkeys(fit.model.robot.units("N m/A")))
    unit = f"unit per {per}" if fit.unscaled else "unit"
    head = ["parameter", "value", unit, "\u00b1 95 %", "std %", "nominal", "\u00b1 std", "against nominal"]
    halves = [table(head, part, words=(2, 7)) for part in (rows[:half], rows[half:]) if part]
    return grid(*halves, kind="two tables")


def correlations(fit: Fit) -> list[tuple[str, str, float]]:
    """Pairs of estimates, gains included, that the data distinguish worst, worst first."""
    std = np.sqrt(np.diag(fit.estimate.covariance))
    found = np.flatnonzero(std > 0.0)
    scaled = fit.estimate.covariance[np.ix_(found, found)] / np.outer(std[found], std[found])
    names = [*fit.names, *(f"gain of {joint}" for joint in fit.model.robot.joints)]
    first, second = np.triu_indices(len(found), 1)
    worst = np.argsort(-np.abs(scaled[first, second]), kind="stable")[:WORST_PAIRS]
    pairs = zip(first[worst], second[worst], strict=True)
    return [(names[found[a]], names[found[b]], float(scaled[a, b])) for a, b in pairs]


def correlation_table(fit: Fit) -> str:
    """The worst pairs, each with a bar."""
    rows = [[f"{a} and {b}", number(r, 4), _share_bar(r)] for a, b, r in correlations(fit)]
    return table(["pair", "correlation", "from \u22121 to 1"], rows, words=(2,))


def _share_bar(share: float) -> str:
    """A bar from the middle, for a number from -1 to 1."""
    length = 108 * abs(share)
    left = 110 - length if share < 0 else 110.0
    return Markup(
        '<svg viewBox="0 0 220 16" role="img"><line class="zero" x1="110" x2="110" y1="1" y2="15"/>'
        f'<rect class="share" x="{left:.1f}" y="3" width="{length:.1f}" height="10"/></svg>'
    )


def unclear_table(fit: Fit) -> str:
    """Parameters that the runs leave open, and the motion that would settle each."""
    rows = [[u.name, number(u.std_percent, 3), u.hint] for u in fit.unclear]
    return table(["parameter", "std %", "motion that would settle it"], rows, words=(2,))


def moved_table(fit: Fit) -> str:
    """Values that no arm can have, and those that export and simulation take."""
    numbers = ((one.name, one.value, one.exported, one.deviations) for one in fit.moved)
    rows = [[name, number(value), number(taken), number(far, 3)] for name, value, taken, far in numbers]
    return table(["parameter", "value", "exported", "standard deviations between"], rows)


def dropped_table(fit: Fit) -> str:
    """Parameters set to zero, and the value that they had."""
    units = dict(
        zip((p.name for p in fit.base.parameters), (p.unit for p in fit.base.parameters), strict=True)
    )
    rows = [
        [name, number(value, 3), unit(units.get(name) or units.get(name.removesuffix("R"), ""))]
        for name, value in fit.dropped.items()
    ]
    return table(["parameter", "value it had", "unit"], rows, words=(2,))


def filter_table(fit: Fit) -> str:
    """How the data were filtered and fitted."""
    filtering = fit.filtering
    chosen = [
        ("sample rate", filtering.rate, "Hz"),
        ("low-pass of positions before differentiation", filtering.position_cutoff, "Hz"),
        ("parallel decimation of torque and regressor", filtering.torque_cutoff, "Hz"),
        ("standstill below", filtering.standstill, ", ".join(dict.fromkeys(fit.model.robot.units("rad/s")))),
    ]
    rows = [[name, NAMELESS if v is None else number(v), unit] for name, v, unit in chosen]
    if filtering.standstill is None:
        rows[3] = ["standstill below", "1 % of each joint's usual speed", ""]
    sources = sorted({run.noise_source for run in (*fit.agreement, *fit.validation)} - {""})
    if sources:
        rows.append(["noise floor measured at", " and ".join(sources), ""])
    rows.append(["decimated samples times joints used", number(fit.rows, max(4, len(str(fit.rows)))), ""])
    return table(["filter", "value", "unit"], rows, words=(2,))
