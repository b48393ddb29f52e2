"""Mismatch: the error that the formulas of findings may have, as smooth curves.

No formula of friction or gears is right to better than a tenth of its torque. Without such curves, the
residual of a correct finding would be explained by a second effect on the same joint.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...effects import TorqueCurve
from ...effects.torque_curve import ABSCISSAE
from ...model import Model
from ..candidates import dependence_of, kind_of
from ..candidates.parts import on_motors
from ..questions.block_answer import Answer
from ..questions.candidate import Candidate
from ..questions.candidate_fit import FORMULA
from ..runs.driven import Driven

CURVE = "curve"
"""Prefix of the names of unknowns for the error of a formula."""

Place = tuple[str, int]
"""Abscissa of a curve, and its joint."""


class Mismatch(NamedTuple):
    """Error that formulas over one abscissa may have on one joint."""

    place: Place
    effect: TorqueCurve  # curve over the range of the fitted runs
    findings: tuple[int, ...]  # indices of the findings that the formulas belong to
    share: np.ndarray  # coefficients of the findings' columns in each spline, (p, s), which are no mismatch
    std: float  # standard deviation of each coefficient of the curve [N m]

    @property
    def names(self) -> list[str]:
        """Names of its unknowns."""
        over, joint = self.place
        return [f"{CURVE} {over} {joint + 1} {k + 1}" for k in range(self.effect.count)]

    def columns(self, splines: np.ndarray, findings: Sequence[Answer]) -> np.ndarray:
        """Splines (r, n, s) without the part that the findings' own columns explain, shape (r, n, s)."""
        formulas = _columns([findings[place] for place in self.findings], splines.shape[1])
        return np.asarray(splines - formulas @ self.share)


def splines_of(effect: TorqueCurve, model: Model, runs: Iterable[Driven]) -> np.ndarray:
    """Torque of all motors per unit of each spline, decimated, shape (r, n, s)."""
    robot = model.robot
    torques = (run.thinned(on_motors(robot, effect.regressor(robot, run.motion))) for run in runs)
    return np.concatenate(list(torques))


def mismatches(
    findings: Sequence[Answer], curve_at: Callable[[Place], tuple[TorqueCurve, np.ndarray]]
) -> list[Mismatch]:
    """Mismatches of all findings that follow a formula over one quantity of one joint."""
    places: dict[Place, list[int]] = {}
    for number, answer in enumerate(findings):
        place = _place(answer.candidate)
        if place is not None:
            places.setdefault(place, []).append(number)
    return [_mismatch(place, numbers, findings, *curve_at(place)) for place, numbers in places.items()]


def _mismatch(
    place: Place, numbers: list[int], findings: Sequence[Answer], effect: TorqueCurve, splines: np.ndarray
) -> Mismatch:
    joint, formulas = place[1], _columns([findings[number] for number in numbers], splines.shape[1])
    size = np.maximum(np.linalg.norm(formulas[:, joint], axis=0), np.finfo(float).tiny)
    share = np.linalg.lstsq(formulas[:, joint] / size, splines[:, joint], rcond=None)[0] / size[:, None]
    torques = [findings[number].torque[:, findings[number].columns.joints == joint] for number in numbers]
    square = sum(float(np.mean(torque**2)) for torque in torques)
    return Mismatch(place, effect, tuple(numbers), share, FORMULA * float(np.sqrt(square)))


def _columns(findings: Sequence[Answer], joints: int) -> np.ndarray:
    """Columns of findings, side by side, shape (r, n, p)."""
    return np.concatenate([answer.columns.everywhere(joints) for answer in findings], axis=2)


def unknowns_of(
    formulas: Sequence[Mismatch], findings: Sequence[Answer], splines: Mapping[Place, np.ndarray]
) -> list[tuple[list[str], np.ndarray, np.ndarray]]:
    """Names, columns and prior standard deviations of mismatches; splines (r, n, s) by place."""
    return [
        (
            mismatch.names,
            mismatch.columns(splines[mismatch.place], findings),
            np.full(mismatch.effect.count, mismatch.std),
        )
        for mismatch in formulas
    ]


def _place(candidate: Candidate) -> Place | None:
    """Abscissa of a candidate's formula and its joint; None if it has no such formula."""
    over = dependence_of(candidate)
    if over not in ABSCISSAE or not kind_of(candidate.effect).formula or len(candidate.joints) != 1:
        return None
    return over, candidate.joints[0]
