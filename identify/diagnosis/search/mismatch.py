"""Mismatch: by how much the formulas of what was found may be wrong, as smooth curves.

No formula of friction or gears is right to better than a tenth of its torque. Without such curves, what is
left of a right one would be explained by a second name on the same joint.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...effects import TorqueCurve
from ...effects.torque_curve import ABSCISSAE
from ...model import Model
from ..candidates import family_of, kind_of
from ..candidates.curves import curve
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
    std: float  # of each coefficient [N m]

    @property
    def names(self) -> list[str]:
        """Of its unknowns."""
        over, joint = self.place
        return [f"{CURVE} {over} {joint + 1} {k + 1}" for k in range(self.effect.count)]

    def columns(self, model: Model, runs: Iterable[Driven]) -> np.ndarray:
        """Torque of all motors per unit of each unknown, thinned out, shape (r, n, p)."""
        robot = model.robot
        torques = (run.thinned(on_motors(robot, self.effect.regressor(robot, run.motion))) for run in runs)
        return np.concatenate(list(torques))


def mismatches(model: Model, runs: Sequence[Driven], found: Sequence[Answer]) -> list[Mismatch]:
    """Of everything found that follows a formula over one quantity of one joint."""
    squares: dict[Place, float] = {}
    for answer in found:
        place = _place(answer.candidate)
        if place is not None:
            own = answer.torque[:, answer.columns.joints == place[1]]
            squares[place] = squares.get(place, 0.0) + FORMULA**2 * float(np.mean(own**2))
    return [
        Mismatch(place, curve(model, *place, runs), float(np.sqrt(square)))
        for place, square in squares.items()
    ]


def with_mismatches(rows: Rows, every: Sequence[Mismatch], columns: Mapping[Place, np.ndarray]) -> Rows:
    """The rows with these unknowns, whose columns (r, n, p) are given by their places."""
    for one in every:
        rows = rows.plus(one.names, columns[one.place], np.full(one.effect.count, one.std))
    return rows


def _place(candidate: Candidate) -> Place | None:
    """What its formula is over, and its joint; None where it has no such formula."""
    family = family_of(candidate)
    if not family or not kind_of(candidate.effect).formula or len(candidate.joints) != 1:
        return None
    over, [joint] = FAMILIES[family].dependence, candidate.joints
    return (over, joint) if over in ABSCISSAE else None
