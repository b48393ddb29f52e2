"""History: an arm's runs with changes as unknowns beside its own, and what a further one would explain."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import linalg

from ..positive_definite import root
from .learned import Learned
from .runs import ArmRuns

STEP, CREEP = SHAPES = "step", "creep"
YEAR = 365.25
ANY = 1e6
"""Standard deviation of a change before the data, in the frame's units: nothing is known."""
PLAUSIBLE = (0.2, 5.0)
"""Friction at a temperature over that at the reference, at least and at most [-]."""
LEAST = 1e-9
"""Share of what a run shows of a cause that is rounding, over what another run shows of it."""


class Change(NamedTuple):
    """A cause, by its place, that changes at once before run `start`, or creeps since the run before it."""

    cause: int
    start: int
    shape: str


class Answer(NamedTuple):
    """A change, its amount in the unit of its cause, a year if it creeps, and that over its deviation."""

    change: Change
    amount: float
    std: float
    deviations: float


class Sums(NamedTuple):
    """Normal matrices (r, d, d) and right-hand sides (r, d) of d columns, cumulated over runs.

    Products (r, d, k) are those with the causes in each run.
    """

    normal: np.ndarray
    right: np.ndarray
    products: np.ndarray


@dataclass(frozen=True, eq=False)
class History:
    """Normal matrices of one arm's runs, changes as columns beside its unknowns."""

    learned: Learned
    runs: ArmRuns

    @cached_property
    def says(self) -> tuple[np.ndarray, np.ndarray]:
        return self.learned.says(self.runs)

    @property
    def directions(self) -> np.ndarray:
        return self.learned.frame.directions

    def series(self, change: Change) -> np.ndarray:
        """How much of a change each run has, shape (r,): none or one; or years since it began."""
        days = self.runs.days
        if change.shape == STEP:
            return (np.arange(len(days)) >= change.start).astype(float)
        return np.maximum(days - days[change.start - 1], 0.0) / YEAR

    @cached_property
    def _arm(self) -> Sums:
        design, (normal, right) = self.runs.design, self.says
        turned = np.swapaxes(design, 1, 2)
        return Sums(
            np.cumsum(turned @ (normal @ design), axis=0),
            np.cumsum(np.einsum("rdm,rm->rd", turned, right), axis=0),
            turned @ (normal @ self.directions.T) * self._factor[:, None, :],
        )

    def _changed(self, changes: list[Change]) -> tuple[Sums, np.ndarray]:
        """The same of c changes, and sums over runs of their products with the arm's unknowns (r, d, c)."""
        (normal, right), factor = self.says, self._factor
        columns = np.zeros((*right.shape, len(changes)))
        for place, one in enumerate(changes):
            by_run = self.series(one) * factor[:, one.cause]
            columns[:, :, place] = by_run[:, None] * self.directions[one.cause]
        weighted, turned = normal @ columns, np.swapaxes(columns, 1, 2)
        own = Sums(
            np.cumsum(turned @ weighted, axis=0),
            np.cumsum(np.einsum("rcm,rm->rc", turned, right), axis=0),
            np.swapaxes(weighted, 1, 2) @ self.directions.T * factor[:, None, :],
        )
        return own, np.cumsum(np.swapaxes(self.runs.design, 1, 2) @ weighted, axis=0)

    @cached_property
    def _own(self) -> tuple[np.ndarray, np.ndarray]:
        """Each cause's own normal number and right-hand side in each run, shapes (r, k)."""
        normal, right = self.says
        directions, factor = self.directions, self._factor
        squares = np.einsum("km,rmn,kn->rk", directions, normal, directions, optimize=True)
        # of a tool, a run with a body that nobody knows shows nothing but rounding
        squares = np.maximum(squares, LEAST * np.max(squares, axis=0))
        return squares * factor**2, (right @ directions.T) * factor

    @cached_property
    def _factor(self) -> np.ndarray:
        """Friction at a run's temperature over that at the reference, shape (r, k); one for all else.

        A worn bearing has so much more friction, in per cent, warm or cold.
        """
        frame, found = self.learned.frame, np.ones((len(self.runs.days), len(self.directions)))
        level, _ = self.learned.level(self.runs)
        in_runs = self.runs.design @ level
        for k in frame.thermal:
            place = frame.causes[k].place
            if abs(level[place]) > 1.0:  # more than units differ by: not near zero
                found[:, k] = np.clip(in_runs[:, place] / level[place], *PLAUSIBLE)
        return found

    def before(self, changes: list[Change]) -> np.ndarray:
        """The arm's unknowns before the first change, by all runs, in the frame's units, shape (m,)."""
        last = len(self.runs.days) - 1
        lower, right = self._posterior(*self._changed(changes), last)
        return linalg.solve_triangular(lower, right, lower=True, trans=1)[: len(self.learned.frame.scale)]

    def _posterior(self, own: Sums, across: np.ndarray, last: int) -> tuple[np.ndarray, np.ndarray]:
        """Of unknowns and changes by runs up to `last`: root L of the precision, and L^-1 right side."""
        arm, units, count = self._arm, self.learned.units, own.right.shape[1]
        normal = np.block([[arm.normal[last], across[last]], [across[last].T, own.normal[last]]])
        precision = np.concatenate([1.0 / units.variance, np.full(count, ANY**-2.0)])
        lower = root(normal + np.diag(precision))
        right = np.append(arm.right[last] + units.mean / units.variance, own.right[last])
        return lower, linalg.solve_triangular(lower, right, lower=True, check_finite=False)

    def asked(self, changes: list[Change], stop: int, starts: list[int]) -> tuple[np.ndarray, np.ndarray]:
        """Amounts of every cause and their deviations by runs before `stop`, each (shapes, starts, k)."""
        changed, crossed = self._changed(changes)
        lower, right = self._posterior(changed, crossed, stop - 1)
        rows = np.array([self.series(Change(0, start, shape))[:stop] for shape in SHAPES for start in starts])
        normal, side = self._own
        products = (self._arm.products[:stop], changed.products[:stop])
        across = np.concatenate(
            [np.tensordot(rows, one, axes=1) for one in products], axis=1
        )  # (s, d + c, k)
        count, size, causes = across.shape
        flat = np.swapaxes(across, 0, 1).reshape(size, -1)
        flat = linalg.solve_triangular(lower, flat, lower=True, check_finite=False)
        explained = np.sum(flat**2, axis=0).reshape(count, causes)
        own = rows**2 @ normal[:stop]
        left = np.maximum(own - explained, LEAST * own + np.finfo(float).tiny)
        amount = (rows @ side[:stop] - (right @ flat).reshape(count, causes)) / left
        shape = (len(SHAPES), len(starts), causes)
        return amount.reshape(shape), (1.0 / np.sqrt(left)).reshape(shape)

    def best(self, changes: list[Change], stop: int, starts: list[int]) -> Answer:
        """The change that makes the runs most probable."""
        amount, std = self.asked(changes, stop, starts)
        place = np.unravel_index(np.argmax(np.abs(amount) / std), amount.shape)
        shape, start, cause = (int(one) for one in place)
        change = Change(cause, starts[start], SHAPES[shape])
        return Answer(change, float(amount[place]), float(std[place]), float(abs(amount[place]) / std[place]))
