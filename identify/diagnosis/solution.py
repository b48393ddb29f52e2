"""Solution: all unknowns at once, by beliefs and by rows made white; and what more columns would gain.

Everything is Gaussian: what is minimised is the sum of squares of white residuals and of unknowns over how
far they may be from zero. A gain is twice the logarithm of a likelihood ratio.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import linalg, special

from .rows import Rows
from .whitening import Whitening

CERTAIN = 1e-12
"""Standard deviation of an unknown that is believed to be zero; a number for the computer."""


class Share(NamedTuple):
    """What one joint's white rows say.

    Attributes:
        gram: Products of columns, shape (b, b).
        right: Products of columns and differences, shape (b,).
        square: Sum of squares of the differences.
        logarithm: Sum of the logarithms of the rows' standard deviations.
    """

    gram: np.ndarray
    right: np.ndarray
    square: float
    logarithm: float

    @classmethod
    def of(
        cls, columns: np.ndarray, target: np.ndarray, logarithm: float, acting: np.ndarray, count: int
    ) -> "Share":
        """Of white columns (v, a) and differences (v,), and the logarithm of what they were divided by.

        The columns are those of the unknowns `acting` (a,) of all `count`; the others' are zero.
        """
        gram, right = np.zeros((count, count)), np.zeros(count)
        gram[np.ix_(acting, acting)] = columns.T @ columns
        right[acting] = columns.T @ target
        return cls(gram, right, float(target @ target), logarithm)


def marginal(shares: Sequence[Share], known: np.ndarray, mean: np.ndarray) -> tuple[np.ndarray, float]:
    """Most likely unknowns (b,), and the logarithm of the probability of all rows whatever they are.

    Args:
        shares: Of all joints.
        known: Inverse variance that is believed of each unknown, shape (b,).
        mean: What each is believed to be, shape (b,).

    Returns:
        The logarithm is without constants that all equally many rows and unknowns have, infinite ones among
        them where nothing is believed.
    """
    gram = np.sum([share.gram for share in shares], axis=0)
    factor, right = factored(gram, known), np.sum([share.right for share in shares], axis=0)
    # What is left at the means comes first: what is known well would drown the rest in its own rounding.
    left = right - gram @ mean
    change = linalg.cho_solve(factor, left)
    loss = sum(share.square for share in shares) - (right + left) @ mean - left @ change
    occam = np.sum(np.log(np.diag(factor[0]))) - 0.5 * np.sum(np.log(known[known > 0]))
    return mean + change, float(-0.5 * loss - sum(share.logarithm for share in shares) - occam)


def factored(gram: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, bool]:
    """Cholesky factor of products of columns (b, b) and beliefs (b,)."""
    whole = gram + np.diag(known)
    # What neither rows nor beliefs say anything of stays at zero.
    whole[np.diag_indices_from(whole)] += 1e-10 * np.maximum(np.diag(whole), 1e-10)
    return linalg.cho_factor(whole)


@dataclass(frozen=True, eq=False)
class Solution:
    """Least squares of rows and beliefs.

    Attributes:
        rows: What is solved.
        whitening: Of its residual.
    """

    rows: Rows
    whitening: Whitening

    @cached_property
    def white(self) -> list[np.ndarray]:
        """White columns of each joint, those that `Rows.acting` tells, (v, a)."""
        return [
            self.whitening.apply(j, self.rows.columns[:, j, acting])
            for j, acting in enumerate(self.rows.acting)
        ]

    @cached_property
    def target(self) -> list[np.ndarray]:
        """White differences of each joint, (v,)."""
        return [self.whitening.apply(j, self.rows.difference[:, j]) for j in range(self.joints)]

    @property
    def joints(self) -> int:
        """Number of joints."""
        return self.rows.difference.shape[1]

    @cached_property
    def shares(self) -> list[Share]:
        """What each joint's rows say."""
        parts = zip(self.white, self.target, self.rows.acting, strict=True)
        return [
            Share.of(white, target, self.whitening.logarithm(joint), acting, len(self.rows.std))
            for joint, (white, target, acting) in enumerate(parts)
        ]

    @cached_property
    def known(self) -> np.ndarray:
        """Inverse variance that is believed of each unknown, shape (b,)."""
        return 1.0 / np.maximum(self.rows.std, CERTAIN) ** 2

    @cached_property
    def _factor(self) -> tuple[np.ndarray, bool]:
        return factored(sum(share.gram for share in self.shares), self.known)  # type: ignore[arg-type]

    @cached_property
    def values(self) -> np.ndarray:
        """Unknowns, shape (b,)."""
        gram, mean = np.sum([share.gram for share in self.shares], axis=0), self.rows.mean
        right = np.sum([share.right for share in self.shares], axis=0)
        return mean + linalg.cho_solve(self._factor, right - gram @ mean)

    @cached_property
    def probability(self) -> float:
        """Logarithm of the probability of all rows, as `marginal` gives it."""
        return marginal(self.shares, self.known, self.rows.mean)[1]

    @cached_property
    def covariance(self) -> np.ndarray:
        """Of the unknowns, shape (b, b)."""
        return linalg.cho_solve(self._factor, np.eye(len(self.rows.std)))

    @cached_property
    def residual(self) -> np.ndarray:
        """What remains of the difference, shape (r, n) [N m]."""
        return self.rows.difference - self.rows.columns @ self.values

    @cached_property
    def left(self) -> list[np.ndarray]:
        """What remains of each joint's white difference, (v,)."""
        parts = zip(self.white, self.target, self.rows.acting, strict=True)
        return [target - white @ self.values[acting] for white, target, acting in parts]

    def believing(self, places: Sequence[int], std: np.ndarray) -> "Solution":
        """The same rows with some unknowns believed to be that far from zero; what is white stays."""
        same = Solution(self.rows.relaxed(places, std), self.whitening)
        same.__dict__.update(white=self.white, target=self.target, shares=self.shares)
        return same

    def alone(self, torque: np.ndarray) -> list[np.ndarray]:
        """White torque (r, n) of each joint, (v,), without what the unknowns could do as well."""
        white = [self.whitening.apply(joint, torque[:, joint]) for joint in range(self.joints)]
        mixed = np.zeros(len(self.rows.std))
        for columns, own, acting in zip(self.white, white, self.rows.acting, strict=True):
            mixed[acting] += columns.T @ own
        values = linalg.cho_solve(self._factor, mixed)
        parts = zip(self.white, white, self.rows.acting, strict=True)
        return [own - columns @ values[acting] for columns, own, acting in parts]

    def profile(self, columns: np.ndarray, joints: np.ndarray) -> "Profile":
        """How further columns (r, len(joints), p) of some joints would do, all unknowns solved anew."""
        return self.profiles([columns], joints)[0]

    def profiles(self, columns: Sequence[np.ndarray], joints: np.ndarray) -> list["Profile"]:
        """The same of each of several, all of the same joints; together they take a fraction of the time."""
        every = np.concatenate(columns, axis=2)
        count = every.shape[2]
        slope, curvature = np.zeros(count), np.zeros((count, count))
        mixed = np.zeros((len(self.rows.std), count))
        for place, joint in enumerate(joints):
            own = self.whitening.apply(int(joint), every[:, place])
            slope += own.T @ self.left[joint]
            curvature += own.T @ own
            mixed[self.rows.acting[joint]] += self.white[joint].T @ own
        curvature -= mixed.T @ linalg.cho_solve(self._factor, mixed)
        stops = np.cumsum([one.shape[2] for one in columns])
        parts = [slice(stop - one.shape[2], stop) for stop, one in zip(stops, columns, strict=True)]
        return [Profile(slope[part], curvature[part, part]) for part in parts]


@dataclass(frozen=True, eq=False)
class Profile:
    """Log likelihood over the coefficients of further columns, everything else being solved for.

    Attributes:
        slope: At zero, shape (p,).
        curvature: Shape (p, p).
    """

    slope: np.ndarray
    curvature: np.ndarray

    def about(self, mean: np.ndarray) -> tuple["Profile", float]:
        """The same from other coefficients (p,) on, and the log likelihood there over that at zero."""
        slope = self.slope - self.curvature @ mean
        return Profile(slope, self.curvature), float(0.5 * mean @ (self.slope + slope))

    def best(self, std: np.ndarray, lower: np.ndarray) -> tuple[np.ndarray, float]:
        """Coefficients (p,) believed to be zero within std (p,), and the logarithm of the Bayes factor.

        A coefficient that physics does not let below its limit stays there, and is not averaged over.
        """
        free, found = np.ones(len(std), bool), np.zeros(len(std))
        whole = self.curvature + np.diag(1.0 / std**2)
        while np.any(free):
            slope = self.slope - whole @ np.where(free, 0.0, found)
            found[free] = np.linalg.solve(whole[np.ix_(free, free)], slope[free])
            below = free & (found < lower)
            if not np.any(below):
                break
            free &= ~below
            found[below] = lower[below]
        if not np.any(found):
            return found, -np.inf
        within = self.curvature[np.ix_(free, free)] * np.outer(std[free], std[free])
        occam = 0.5 * np.linalg.slogdet(np.eye(int(np.sum(free))) + within)[1]
        gain = self.slope @ found - 0.5 * found @ whole @ found
        return found, float(gain - occam) + one_sided(lower[free], std[free])


def one_sided(lower: np.ndarray, std: np.ndarray) -> float:
    """Logarithm of what coefficients (p,) gain that physics does not let below a limit.

    Half as many were possible, where the limit is in the middle of what is believed.
    """
    return float(-np.sum(special.log_ndtr(-lower / std)))
