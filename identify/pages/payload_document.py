"""A payload on the flange as text: values with intervals, their source, the check, and the vendors' forms."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..document.document import (
    Block,
    Cell,
    Code,
    Document,
    Number,
    Numbers,
    Paragraph,
    Row,
    Section,
    Statements,
    Table,
)
from ..notebook import counted
from ..payload.body import MASS, Interval
from ..payload.formats import FORMATS
from ..payload.payload_estimate import (
    CENTER_NAMES,
    DESCRIPTION,
    DIFFERENCE,
    FIT,
    INERTIA_NAMES,
    PayloadEstimate,
)
from ..text_table import NORMAL_95, digits, fixed

FORMAT = 1
"""Version of payload.json."""
FAR = 3.0
"""Distance of the consistent body from the estimate beyond which the page doubts it [standard deviations].
Chi of ten parameters exceeds 4.3 in 5 % of all cases if all constraints are active, and few are."""
MAINLY = 2.0
"""Ratio of the interval to that of an exactly known arm, from which on the arm is the main uncertainty."""
SOURCES = {
    FIT: "a fit of the arm",
    DIFFERENCE: "a run without the payload",
    DESCRIPTION: "the robot description alone",
}
WEIGHED = "a fit with drive gains from a payload that was weighed (exidyn identify --payload RUN --mass KG)"
EMPTY = "a run of the same motion without the payload, as --empty, or a fit of the arm, as --fit"
CURES = {
    (FIT, True): WEIGHED,
    (FIT, False): "a longer run with the payload, or several, which show changes since the fit better",
    (DIFFERENCE, True): WEIGHED,
    (DIFFERENCE, False): "a fit of the arm, as --fit",
    (DESCRIPTION, True): EMPTY,
    (DESCRIPTION, False): EMPTY,
}
"""What would make the interval narrower, by what is known of the arm and whether drive gains are nominal."""


def payload_document(result: PayloadEstimate, formats: Sequence[str] = ()) -> Document:
    """The page, with the payload in the form of each named controller."""
    runs = counted(len(result.runs), "run")
    note = (
        f"{runs} of {result.seconds:.0f} s with the payload; the arm is known from {SOURCES[result.source]}"
    )
    said, values = Statements(verdict(result), "verdict"), _values(result)
    forms = [block for name in formats for block in _form(result, name)]
    sections = [
        Section("verdict", "Result", [said]),
        Section("values", f"Payload in frame {result.frame}", [values]),
        Section("check", "Check in poses that were not used", _check(result)),
        Section("forms", "Forms of controllers", forms),
    ]
    return Document(f"Payload of {result.robot}", note, sections, brief=[said, values, *forms])


def _form(result: PayloadEstimate, name: str) -> list[Block]:
    """The payload as a controller takes it, or why it cannot be stated."""
    if obstacle := result.obstacle(name):
        return [Paragraph(obstacle)]
    return [Paragraph(f"{name}: {FORMATS[name].title}"), Code(result.text(name))]


def verdict(result: PayloadEstimate) -> list[str]:
    """Sentences on the payload, on what is open, and on what would help."""
    low, high = digits(result.mass.low, 4), digits(result.mass.high, 4)
    center = ", ".join(fixed(1e3 * value, 0) for value in result.body.center)
    sentences = [
        f"The payload weighs {digits(result.mass.value)} kg (95 %: {low} to {high} kg), with its center of "
        f"mass at ({center}) mm in frame {result.frame}."
    ]
    if result.mass.low <= 0.0:
        sentences.append("The mass may be zero, so the center of mass and the inertia are not to be used.")
    if result.distance > FAR:
        sentences.append(_impossible(result))
    if result.check.poses and not result.check.passed:
        sentences.append(
            f"WRONG in poses that were not used: the torque differs by {result.check.worst:.1f} standard "
            f"deviations, more than the {result.check.limit:.1f} that noise explains. Look for contact, a "
            "moving payload, cables, or an arm that has changed."
        )
    if names := result.undetermined:
        sentences.append(f"These runs do not determine {', '.join(names)}; see the intervals.")
    sentences += _by_arm(result)
    if not result.check.poses:
        sentences.append("The runs are too short for a check in poses that were not used.")
    elif result.check.passed:
        sentences.append("The torque in two poses that were not used agrees.")
    return [*sentences, *result.warnings]


def _impossible(result: PayloadEstimate) -> str:
    """A sentence on an estimate that no body can have."""
    mass, half = result.estimate[MASS], NORMAL_95 * np.sqrt(result.covariance[MASS, MASS])
    return (
        f"WRONG as a body: the values are those of the nearest body, {result.distance:.1f} standard "
        f"deviations from the estimate (limit {FAR:g}). The estimate alone has a mass of {digits(mass, 4)} ± "
        f"{digits(half, 2)} kg. The model of the arm may lack friction or elasticity: run exidyn diagnose on "
        "a run without the payload."
    )


def _by_arm(result: PayloadEstimate) -> list[str]:
    """A sentence on the share of arm and gains in the interval of the mass, if it is the larger one."""
    exact, half = result.certain.mass.half, result.mass.half
    if not half > MAINLY * exact:
        return []
    return [
        f"Of ± {digits(half, 2)} kg, all but ± {digits(exact, 2)} kg comes from what is uncertain of the "
        f"arm, its friction and its drive gains. For less: {CURES[result.source, result.nominal_gains]}."
    ]


def _values(result: PayloadEstimate) -> Table:
    rows: list[Row] = [_row("mass", "kg", result.mass, result.certain.mass, 1.0)]
    pairs = zip(CENTER_NAMES, result.center, result.certain.center, strict=True)
    rows += [_row(f"center {name}", "mm", value, exact, 1e3) for name, value, exact in pairs]
    pairs = zip(INERTIA_NAMES, result.inertia, result.certain.inertia, strict=True)
    rows += [_row(name, "kg m²", value, exact, 1.0) for name, value, exact in pairs]
    return Table(["", "value", "95 % interval", "± exact arm", "unit"], rows, words=(4,))


def _row(name: str, unit: str, value: Interval, exact: Interval, scale: float) -> list[Cell]:
    ends: Cell = "not bounded"
    if np.isfinite(value.half):
        ends = Numbers("{} to {}", (Number(scale * value.low, 4), Number(scale * value.high, 4)))
    return [name, Number(scale * value.value, 4), ends, Number(scale * exact.half, 2), unit]


def _check(result: PayloadEstimate) -> list[Paragraph | Table]:
    if not result.check.poses:
        return []
    rows: list[Row] = []
    for number, pose in enumerate(result.check.poses, start=1):
        where = ", ".join(f"{value:.2f}" for value in pose.position + 0.0)
        rows.append([f"pose {number}: ({where}) rad"])
        columns = zip(result.joints, pose.measured, pose.predicted, NORMAL_95 * pose.std, strict=True)
        rows += [
            [joint, *map(Number, (measured, predicted)), Number(measured - predicted, 2), Number(half, 2)]
            for joint, measured, predicted, half in columns
        ]
    return [
        Paragraph("Mean torque of the payload over at most a second, left out of the estimate [N m]."),
        Table(["joint", "measured", "predicted", "difference", "95 %"], rows),
    ]


def payload_table(result: PayloadEstimate, formats: Sequence[str] = ()) -> dict[str, Any]:
    """The result for JSON."""
    moments, axes = result.body.principal
    return {
        "exidyn_payload": FORMAT,
        "robot": result.robot,
        "runs": result.runs,
        "empty": result.empty,
        "seconds": result.seconds,
        "arm_known_from": result.source,
        "frame": result.frame,
        "mass": _interval(result.mass, result.certain.mass),
        "center": dict(zip(CENTER_NAMES, map(_interval, result.center, result.certain.center), strict=True)),
        "inertia": dict(
            zip(INERTIA_NAMES, map(_interval, result.inertia, result.certain.inertia), strict=True)
        ),
        "principal_moments": moments,
        "principal_axes": axes,
        "undetermined": result.undetermined,
        "estimate": result.estimate,
        "covariance": result.covariance,
        "distance": result.distance,
        "check": {
            "passed": result.check.passed,
            "worst": result.check.worst,
            "limit": result.check.limit,
            "poses": [pose._asdict() for pose in result.check.poses],
        },
        "gain_error": result.gain_error,
        "gain_std": result.gain_std,
        "residual": np.asarray(result.noise),
        "warnings": result.warnings,
        "forms": {name: result.text(name) for name in formats or FORMATS if not result.obstacle(name)},
    }


def _interval(value: Interval, exact: Interval) -> dict[str, Any]:
    return {
        "value": value.value,
        "low": value.low,
        "high": value.high,
        "half_if_arm_exact": exact.half,
        "unit": value.unit,
    }
