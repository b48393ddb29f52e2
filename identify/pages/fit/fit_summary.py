"""A fit as one page of text, in the manner of a regression summary."""

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...effects import Effect, name_of
from ...fit.agreement import Agreement
from ...fit.base_parameters import BaseParameters
from ...fit.fit import Fit
from ...fit.fit_warnings import OPEN
from ...fit.verdict import NORMAL_95, TO_NOISE, gains_estimated, gains_sentence, open_gain_sentences, verdict
from ...model import Model
from ...text_table import WIDTH, at_point, digits, paragraph, table
from .parameter_table import joints_of, parameter_table, unit_of

MOVED = "Exported otherwise"
"""Heading of the values that no arm can have."""


def summary(fit: Fit) -> str:
    """One page: what was identified, how surely, how well it fits, and what remains open."""
    title = f"Identified dynamics of {fit.model.robot.name}"
    parts = {
        "Drive gains": _gains(fit),
        "Parameters": parameter_table(fit),
        "Fit by joint": _fits(fit),
        "Open": _open(fit),
        **({MOVED: _moved(fit)} if fit.moved else {}),
        "Composition of base parameters": _composition(fit),
        "Shapes of effects, as stated or fitted": _shapes(fit),
        "Verdict and warnings": [line for v in verdict(fit) for line in paragraph(v, "  ", "- ")],
    }
    page = [[title.center(WIDTH).rstrip(), "=" * WIDTH, *_header(fit)]]
    page += [[heading, "-" * WIDTH, *lines] for heading, lines in parts.items()]
    return "\n\n".join("\n".join(part) for part in page) + "\n" + "=" * WIDTH


def _header(fit: Fit) -> list[str]:
    robot, filtering = fit.model.robot, fit.filtering
    sources = sorted({a.noise_source for a in fit.agreement if a.noise_source})
    names = ", ".join(f"{number} {joint}" for number, joint in enumerate(robot.joints, 1))
    standstill = filtering.standstill
    below = "1 % of usual speed" if standstill is None else f"{digits(standstill)} {unit_of(fit, 'rad/s')}"
    position, torque = _hertz(filtering.position_cutoff), _hertz(filtering.torque_cutoff)
    pairs = [
        ("Robot", robot.name, "Method", fit.estimate.method),
        ("Runs", str(len(fit.runs)), "Base parameters", _counted(fit)),
        ("Rows", str(fit.rows), "Condition number", digits(fit.condition)),
        ("Position cut-off", position, "Noise floor from", ", ".join(sources) or "-"),
        ("Torque cut-off", torque, "Standstill below", below),
    ]
    half = WIDTH // 2
    lines = [f"{a + ':':<18}{b}".ljust(half) + f"{c + ':':<18}{d}" for a, b, c, d in pairs]
    for label, text in (("Joints", names), ("Identified from", ", ".join(fit.runs))):
        lines += paragraph(text, " " * 18, f"{label + ':':<18}")
    held_out = ", ".join(a.run for a in fit.validation)
    lines += paragraph(held_out, " " * 18, f"{'Validated on:':<18}") if held_out else []
    # What spoils other numbers is read before them.
    return lines + [line for words in open_gain_sentences(fit) for line in paragraph(words, "  ", "! ")]


def _counted(fit: Fit) -> str:
    rank = len(fit.names) + len(fit.dropped)
    return f"{rank} (rank), {len(fit.names)} kept" if fit.dropped else f"{rank} (rank), all kept"


def _hertz(frequency: float | None) -> str:
    return "from the data" if frequency is None else f"{digits(frequency)} Hz"


def _gains(fit: Fit) -> list[str]:
    robot, estimate = fit.model.robot, fit.estimate
    if not gains_estimated(fit):
        if fit.unscaled or fit.measures == "torque":
            return paragraph(gains_sentence(fit))
        return paragraph(gains_sentence(fit)) + table(
            ["joint", unit_of(fit, "N m/A")],
            list(zip(robot.joints, at_point([digits(g) for g in estimate.gain]), strict=True)),
        )
    half = NORMAL_95 * estimate.gain_std
    columns = [
        [digits(v) for v in values]
        for values in (
            estimate.gain,
            100 * estimate.gain_std / np.abs(estimate.gain),
            estimate.gain - half,
            estimate.gain + half,
            robot.drive_gain,
            100 * (estimate.gain / robot.drive_gain - 1),
        )
    ]
    head = ["joint", unit_of(fit, "N m/A"), "std %", "from", "to (95%)", "nominal", "off nominal %"]
    if fit.gains_unstated:  # a gain of 1 was never stated
        head, columns = head[:5], columns[:4]
    return table(head, _rows(list(robot.joints), *columns))


def _rows(first: Sequence[str], *columns: Sequence[str]) -> list[list[str]]:
    return [list(row) for row in zip(first, *(at_point(column) for column in columns), strict=True)]


def pooled(agreements: Sequence[Agreement]) -> Agreement:
    """Several runs as one."""
    together: dict[str, Any] = {
        name: np.concatenate([getattr(a, name) for a in agreements])
        for name in ("time", "measured", "predicted", "weight", "velocity")
    }
    noise = np.sqrt(np.mean([a.noise**2 for a in agreements], axis=0))
    name = agreements[0].run if len(agreements) == 1 else f"{len(agreements)} runs together"
    return replace(agreements[0], run=name, position=None, noise=noise, **together)


def _fits(fit: Fit) -> list[str]:
    if not fit.agreement:
        return paragraph("not kept in the file: compare with runs by Fit.agree")
    unit = "A" if fit.unscaled else unit_of(fit, "N m")
    head = ["joint", f"residual {unit}", f"noise {unit}", "over noise", "", "relative %", "R^2"]
    rows: list[list[str]] = []
    runs = [("identified from", pooled(fit.agreement)), *(("validated on", a) for a in fit.validation)]
    for role, agreement in runs:
        rows += [[f"{role} {agreement.run}"], *_fit_rows(fit, agreement)]
    lines = table(head, rows, left=(0, 4))
    return lines + paragraph(
        "over noise: residual over the noise floor, 1 where nothing is missing. "
        f"* above {TO_NOISE}: what the model leaves is at least 0.8 of the noise itself; "
        "physics is missing there."
    )


def _fit_rows(fit: Fit, agreement: Agreement) -> list[list[str]]:
    over = agreement.over_noise
    values = (agreement.residual_rms, agreement.noise, over, 100 * agreement.relative)
    residual, noise, times, relative = (at_point([digits(v) for v in column]) for column in values)
    flags = ["*" if o > TO_NOISE else "" for o in over]
    explained = [f"{r:.6f}" for r in agreement.r_squared]
    joints = [f"  {joint}" for joint in fit.model.robot.joints]
    return [list(r) for r in zip(joints, residual, noise, times, flags, relative, explained, strict=True)]


def _open(fit: Fit) -> list[str]:
    if not fit.unclear:
        return paragraph(f"Nothing: every parameter that was kept is known to {OPEN:g} % or better.")
    head = ["name", "std %", "would be settled by a run that does this"]
    rows = _rows([u.name for u in fit.unclear], [digits(u.std_percent) for u in fit.unclear])
    return table(head, [[*row, u.hint] for row, u in zip(rows, fit.unclear, strict=True)], left=(0, 2))


def _moved(fit: Fit) -> list[str]:
    """Values that no arm can have, and those that export and simulation take."""
    columns = [
        [digits(value) for value in column]
        for column in zip(*((one.value, one.exported, one.deviations) for one in fit.moved), strict=True)
    ]
    lines = table(["name", "value", "exported", "deviations"], _rows([m.name for m in fit.moved], *columns))
    return lines + paragraph(
        "exported: nearest that an arm can have, by the fit's own covariance. deviations: how far that is "
        "from the value, in its standard deviations. All others are exported within their 95 %."
    )


def _shapes(fit: Fit) -> list[str]:
    """Nonlinear unknowns, one effect a line."""
    lines = []
    for effect in fit.model.effects:
        values = [
            f"{name} {getattr(effect, name):.4g} {_shape_unit(effect, fit.model, shape.unit)}"
            for name, shape in effect.shapes().items()
        ]
        if values:
            where = ", ".join(dict.fromkeys(joints_of(effect, fit.model)))
            lines += paragraph(f"{name_of(effect)} ({where}): {', '.join(values)}", "  ")
    return lines or ["None of the effects has one."]


def _shape_unit(effect: Effect, model: Model, turning: str) -> str:
    """Unit of a shape, by the joints on which its effect acts."""
    robot = model.robot
    joints = [joint for joint in effect.parameter_joints(robot) if joint is not None]
    return ", ".join(dict.fromkeys(robot.unit(joint, turning) for joint in joints)) or turning


def _composition(fit: Fit) -> list[str]:
    structure: BaseParameters = fit.structure or fit.base
    lines = [line for e in structure.expressions for line in _wrapped_sum(e)]
    alone = len(structure.kept) - len(structure.expressions)
    lines += paragraph(f"The other {alone} are single parameters.") if alone else []
    hidden = structure.without_effect
    if hidden:
        lines += paragraph("No motion of this arm reveals: " + ", ".join(hidden), "  ", "")
    return lines


def _wrapped_sum(expression: str) -> list[str]:
    """A sum wrapped before its signs."""
    name, right = expression.split(" = ", 1)
    terms = re.sub(r" ([+-]) (\S+) ([A-Za-z])", r" \1~\2~\3", f" {right}")
    terms = re.sub(r" ([+-]) ", r" \1~", terms).strip()
    return [line.replace("~", " ") for line in paragraph(terms, " " * (len(name) + 3), f"{name} = ")]
