"""Solution: all unknowns at once, by beliefs and by rows made white; and what more columns would gain.

Everything is Gaussian: what is minimised is the sum of squares of white residuals and of unknowns over how
far they may be from zero. A gain is twice the logarithm of a likelihood ratio.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import linalg, special

from .rows import Rows
from .whitening import Whitening

CERTAIN = 1e-12
"""Variance of an unknown that is believed to be zero, over that of a row [-]; a number for the computer."""


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
        """White columns of each joint, (v, b)."""
        return [self.whitening.apply(j, self.rows.columns[:, j]) for j in range(self.joints)]

    @cached_property
    def target(self) -> list[np.ndarray]:
        """White differences of each joint, (v,)."""
        return [self.whitening.apply(j, self.rows.difference[:, j]) for j in range(self.joints)]

    @property
    def joints(self) -> int:
        """Number of joints."""
        return self.rows.difference.shape[1]

    @cached_property
    def _factor(self) -> tuple[np.ndarray, bool]:
        gram = sum((columns.T @ columns for columns in self.white), np.zeros((0, 0)) if not self.white else 0)
        known = 1.0 / np.maximum(self.rows.std, CERTAIN) ** 2
        gram = np.asarray(gram) + np.diag(known)
        # What neither rows nor beliefs say anything of stays at zero.
        gram[np.diag_indices_from(gram)] += 1e-10 * np.maximum(np.diag(gram), 1e-10)
        return linalg.cho_factor(gram)

    @cached_property
    def values(self) -> np.ndarray:
        """Unknowns, shape (b,)."""
        right = sum(columns.T @ target for columns, target in zip(self.white, self.target, strict=True))
        return linalg.cho_solve(self._factor, right)

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
        pairs = zip(self.white, self.target, strict=True)
        return [target - columns @ self.values for columns, target in pairs]

    def profile(self, columns: np.ndarray, joints: np.ndarray) -> "Profile":
        """How further columns (r, len(joints), p) of some joints would do, all unknowns solved anew."""
        count = columns.shape[2]
        slope, curvature = np.zeros(count), np.zeros((count, count))
        mixed = np.zeros((len(self.rows.std), count))
        for place, joint in enumerate(joints):
            own = self.whitening.apply(int(joint), columns[:, place])
            slope += own.T @ self.left[joint]
            curvature += own.T @ own
            mixed += self.white[joint].T @ own
        shift = linalg.cho_solve(self._factor, mixed)
        return Profile(slope, curvature - mixed.T @ shift)


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

        A coefficient that physics does not let below zero stays there; it then counts for nothing.
        """
        free = np.arange(len(std))
        while len(free):
            curvature = self.curvature[np.ix_(free, free)] + np.diag(1.0 / std[free] ** 2)
            values = np.linalg.solve(curvature, self.slope[free])
            below = values < lower[free]
            if not np.any(below):
                break
            free = free[~below]
        found = np.zeros(len(std))
        if not len(free):
            return found, -np.inf
        found[free] = values
        scaled = np.eye(len(free)) + self.curvature[np.ix_(free, free)] * np.outer(std[free], std[free])
        # What physics forbids was not believed: a half, where the limit is in the middle.
        sided = -np.sum(special.log_ndtr(-lower[free] / std[free]))
        return found, float(0.5 * self.slope[free] @ values - 0.5 * np.linalg.slogdet(scaled)[1] + sided)
