"""Mismatch: by how much the formulas of what was found may be wrong, as smooth curves.

No formula of friction or gears is right to better than a tenth of its torque. Without such curves, what is
left of a right one would be explained by a second name on the same joint.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...effects import TorqueCurve
from ...effects.torque_curve import ABSCISSAE
from ...model import Model
from ..candidates import family_of, kind_of
from ..candidates.parts import on_motors
from ..findings.family import FAMILIES
from ..questions.block_answer import Answer
from ..questions.candidate import Candidate
from ..questions.candidate_fit import FORMULA
from ..runs.driven import Driven
from ..runs.rows import Rows

CURVE = "curve"
"""How unknowns begin by which the formula of a finding may be wrong."""

Place = tuple[str, int]
"""What a curve is over, and its joint."""


class Mismatch(NamedTuple):
    """By how much formulas of one dependence on one joint may be wrong."""

    place: Place
    effect: TorqueCurve  # over the range of the runs that were fitted
    findings: tuple[int, ...]  # those whose formulas they are, by their places
    share: np.ndarray  # of each of their coefficients in each spline, (p, s): that much is no mismatch
    std: float  # of each coefficient of the curve [N m]

    @property
    def names(self) -> list[str]:
        """Of its unknowns."""
        over, joint = self.place
        return [f"{CURVE} {over} {joint + 1} {k + 1}" for k in range(self.effect.count)]

    def columns(self, splines: np.ndarray, found: Sequence[Answer]) -> np.ndarray:
        """What splines (r, n, s) have beyond the torques of the findings themselves, shape (r, n, s)."""
        formulas = _columns([found[place] for place in self.findings], splines.shape[1])
        return np.asarray(splines - formulas @ self.share)


def splines_of(effect: TorqueCurve, model: Model, runs: Iterable[Driven]) -> np.ndarray:
    """Torque of all motors per unit of each spline, thinned out, shape (r, n, s)."""
    robot = model.robot
    torques = (run.thinned(on_motors(robot, effect.regressor(robot, run.motion))) for run in runs)
    return np.concatenate(list(torques))


def mismatches(
    found: Sequence[Answer], curve_at: Callable[[Place], tuple[TorqueCurve, np.ndarray]]
) -> list[Mismatch]:
    """Of everything found that follows a formula over one quantity of one joint.

    Args:
        found: Effects, with their columns over some runs.
        curve_at: The curve at a place, and its splines (r, n, s) over the same runs.
    """
    places: dict[Place, list[int]] = {}
    for number, answer in enumerate(found):
        place = _place(answer.candidate)
        if place is not None:
            places.setdefault(place, []).append(number)
    return [_mismatch(place, numbers, found, *curve_at(place)) for place, numbers in places.items()]


def _mismatch(
    place: Place, numbers: list[int], found: Sequence[Answer], effect: TorqueCurve, splines: np.ndarray
) -> Mismatch:
    joint, formulas = place[1], _columns([found[number] for number in numbers], splines.shape[1])
    size = np.maximum(np.linalg.norm(formulas[:, joint], axis=0), np.finfo(float).tiny)
    share = np.linalg.lstsq(formulas[:, joint] / size, splines[:, joint], rcond=None)[0] / size[:, None]
    torques = [found[number].torque[:, found[number].columns.joints == joint] for number in numbers]
    square = sum(float(np.mean(torque**2)) for torque in torques)
    return Mismatch(place, effect, tuple(numbers), share, FORMULA * float(np.sqrt(square)))


def _columns(found: Sequence[Answer], joints: int) -> np.ndarray:
    """Columns of some findings, shape (r, n, p)."""
    return np.concatenate([answer.columns.everywhere(joints) for answer in found], axis=2)


def with_mismatches(
    rows: Rows, formulas: Sequence[Mismatch], found: Sequence[Answer], splines: Mapping[Place, np.ndarray]
) -> Rows:
    """The rows with these unknowns; splines (r, n, s) of each place and findings are over the same runs."""
    for mismatch in formulas:
        columns = mismatch.columns(splines[mismatch.place], found)
        rows = rows.plus(mismatch.names, columns, np.full(mismatch.effect.count, mismatch.std))
    return rows


def _place(candidate: Candidate) -> Place | None:
    """What its formula is over, and its joint; None where it has no such formula."""
    family = family_of(candidate)
    if not family or not kind_of(candidate.effect).formula or len(candidate.joints) != 1:
        return None
    over, [joint] = FAMILIES[family].dependence, candidate.joints
    return (over, joint) if over in ABSCISSAE else None
