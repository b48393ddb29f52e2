"""Sizes in words: the torque of a finding with its 95 % interval, and why a number of it is not given."""

from collections.abc import Mapping

from ...text_table import digits
from ..findings.axes import AXES
from ..findings.diagnosis import Diagnosis
from ..findings.quantities import with_interval
from ..findings.size import OF_A_CURVE, LeftOut, Point, Size
from .measures import revolute
from .naming import effect_words, joined

BESIDE = "root mean square, that no other parameter can take over"


def unit_over(size: Size, diagnosis: Diagnosis) -> str:
    """Unit of what the torque depends on; empty where it follows nothing."""
    return AXES[size.over].unit(revolute(diagnosis, size.joint)) if size.over else ""


def size_words(size: Size, diagnosis: Diagnosis) -> str:
    """What is known of the torque, as a part of a sentence: of its points, or else of what is its alone."""
    unit = diagnosis.torque_units[size.joint]
    if not size.known:
        return f"it gives {with_interval(size.beside_rms, size.beside_std)} {unit}, {BESIDE}"
    axis = AXES[size.over]
    against = " against the motion" if axis.braking else ""
    first, *others = (_place(point, unit_over(size, diagnosis)) for point in size.points)
    torques = [with_interval(point.torque, point.std) for point in size.points]
    if size.change:
        said = joined([f"{t} {unit} at {at}" for t, at in zip(torques[1:], others, strict=True)])
        return f"over that at a {axis.words} of {first}, its torque{against} is {said}"
    said = joined([f"{t} {unit} at {at}" for t, at in zip(torques, (first, *others), strict=True)])
    return f"over the {axis.words}, its torque{against} is {said}"


def _place(point: Point, unit: str) -> str:
    return f"{digits(point.at, 2)} {unit} ({point.which})"


def size_rows(size: Size, diagnosis: Diagnosis) -> list[tuple[str, float, float]]:
    """The same as rows of a table: where, torque [N m] and standard deviation."""
    if not size.known:
        return [("root mean square", size.beside_rms, size.beside_std)]
    shown, unit = size.points[1 if size.change else 0 :], unit_over(size, diagnosis)
    return [(_place(point, unit), point.torque, point.std) for point in shown]


def rows_head(size: Size, diagnosis: Diagnosis) -> str:
    """What those rows are."""
    if not size.known:
        return "torque that no other parameter can take over"
    axis = AXES[size.over]
    against = " against the motion" if axis.braking else ""
    first = (
        f" over that at {digits(size.points[0].at, 2)} {unit_over(size, diagnosis)}," if size.change else ""
    )
    return f"torque{against}{first} at a {axis.words} of"


def left_out_words(left_out: Mapping[str, LeftOut]) -> dict[str, str]:
    """Name of a number that is not given -> why, as a sentence; empty for those of a curve."""
    return {
        name: "" if reason == OF_A_CURVE else f"{name} is not given, since {_why(reason)}."
        for name, reason in left_out.items()
    }


def _why(reason: LeftOut) -> str:
    if not reason.beside:
        return "these runs do not determine it beside all other parameters"
    of = f" of {effect_words(reason.effect)}" if reason.effect else ""
    return f"these runs do not tell it from {reason.beside}{of}, with which it changes together"
