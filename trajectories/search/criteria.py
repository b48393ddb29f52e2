r"""Criteria: how good an information matrix is, as a number to be made small, and its gradient.

The information matrix :math:`M = W^T W` (rows in units of their noise) adds up over runs, over earlier
data and over priors, so a criterion need not know what it is the sum of. A criterion is a function of M
and of the size of each parameter, shape (b,), that gives the value and the derivative by M, symmetric.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from ..errors import UnknownChoice

Criterion = Callable[[np.ndarray, np.ndarray], tuple[float, np.ndarray]]

SMALLEST = 1e-14
"""Share of the largest eigenvalue that rounding leaves of a zero one: less is taken as this."""


def condition(information: np.ndarray, size: np.ndarray, power: float = np.inf) -> tuple[float, np.ndarray]:
    """Logarithm of the condition number of the regressor with scaled columns.

    Columns have norm one, or less where a scale reaches its bound: a joint that creeps has small columns, and
    scaled to one they would seem to be known as well as any other.

    Args:
        information: Shape (b, b).
        size: Largest scale of each column; infinite for a scale that is always one over the column's norm.
        power: Where finite, sums of this power over all eigenvalues stand for the largest and for the
            smallest: an upper bound, smooth where eigenvalues meet.
    """
    norm = np.sqrt(np.diag(information))
    scale = np.minimum(1.0 / norm, size)
    scaled = information * np.outer(scale, scale)
    values, vectors = eigh(scaled)
    values = np.maximum(values, SMALLEST * values[-1])
    high, by_high = _peak(np.log(values), power)
    low, by_low = _peak(-np.log(values), power)
    by_value = 0.5 * (by_high - by_low) / values
    by_scaled = (vectors * by_value) @ vectors.T
    through_scale = np.where(scale < size, np.sum(by_scaled * scaled, axis=1) / norm**2, 0.0)
    return 0.5 * (high + low), by_scaled * np.outer(scale, scale) - np.diag(through_scale)


def volume(information: np.ndarray, size: np.ndarray) -> tuple[float, np.ndarray]:
    """D-optimality: mean logarithm of a deviation, from the volume of the confidence ellipsoid.

    Args:
        information: Shape (b, b).
        size: Size of each parameter; the deviations are relative to it.
    """
    covariance, logarithm = _inverted(information, size)
    count = len(size)
    return 0.5 / count * logarithm, -0.5 / count * covariance * np.outer(size, size)


def average(information: np.ndarray, size: np.ndarray) -> tuple[float, np.ndarray]:
    """A-optimality: logarithm of the root mean square deviation, relative to the parameters' sizes."""
    return _deviation(information, size, 1.0)


def worst(information: np.ndarray, size: np.ndarray, power: float = 16.0) -> tuple[float, np.ndarray]:
    """Logarithm of the largest deviation relative to its parameter's size, or a little more.

    Args:
        information: Shape (b, b).
        size: Size of each parameter.
        power: Exponent of the sum of variances that stands for the largest, smooth where two are equal. With
            sixteen, and forty parameters, it is at most 26 % above the largest variance: 12 % above the
            largest deviation.
    """
    return _deviation(information, size, power)


@dataclass(frozen=True)
class Focus:
    """Like `volume`, of some parameters only (D_s): the others are unknown too, but need not be known well.

    Attributes:
        columns: Places of the base parameters that matter.
    """

    columns: tuple[int, ...]

    @classmethod
    def on(cls, names: Sequence[str], wanted: Sequence[str]) -> "Focus":
        """Focus on some base parameters of all `names`; a wanted name stands for all that begin with it.

        Raises:
            UnknownChoice: A name with which none begins.
        """
        for beginning in wanted:
            if not any(name.startswith(beginning) for name in names):
                raise UnknownChoice("base parameter", beginning, names)
        return cls(tuple(k for k, name in enumerate(names) if name.startswith(tuple(wanted))))

    def __call__(self, information: np.ndarray, size: np.ndarray) -> tuple[float, np.ndarray]:
        """Value and derivative, as of every criterion."""
        some = _inverted(information, size)[0][:, list(self.columns)]
        own = some[list(self.columns)]
        count = len(self.columns)
        gradient = -0.5 / count * some @ np.linalg.solve(own, some.T)
        return 0.5 / count * float(np.linalg.slogdet(own)[1]), gradient * np.outer(size, size)


def _deviation(information: np.ndarray, size: np.ndarray, power: float) -> tuple[float, np.ndarray]:
    """Logarithm of the root of a power sum of relative variances; of their mean where the power is 1."""
    covariance, _ = _inverted(information, size)
    variance = np.diag(covariance)
    highest, share = _peak(np.log(variance), power)
    if power == 1.0:
        highest -= np.log(len(variance))
    gradient = -(covariance * (0.5 * share / variance)) @ covariance
    return 0.5 * highest, gradient * np.outer(size, size)


def _inverted(information: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, float]:
    """Covariance of parameters in units of their size, and the logarithm of its determinant.

    By way of columns scaled to one: sizes spread the eigenvalues by another factor of thousands, whose
    smallest would then be rounding.
    """
    scale = 1.0 / np.sqrt(np.diag(information))
    values, vectors = eigh(information * np.outer(scale, scale))
    values = np.maximum(values, SMALLEST * values[-1])
    relative = scale / size
    covariance = ((vectors / values) @ vectors.T) * np.outer(relative, relative)
    return covariance, float(2 * np.sum(np.log(relative)) - np.sum(np.log(values)))


def _peak(logarithms: np.ndarray, power: float) -> tuple[float, np.ndarray]:
    """Largest logarithm, or that of the power sum, and its derivative by each."""
    largest = float(np.max(logarithms))
    if np.isinf(power):
        share = np.zeros(len(logarithms))
        share[int(np.argmax(logarithms))] = 1.0
        return largest, share
    weights = np.exp(power * (logarithms - largest))
    return largest + float(np.log(weights.sum())) / power, weights / weights.sum()


CRITERIA: dict[str, Criterion] = {
    "condition": condition,
    "volume": volume,
    "average": average,
    "worst": worst,
}
"""What a trajectory can be made best for, by the name the command line gives it."""


def name_of(criterion: Criterion) -> str:
    """A criterion's name in `CRITERIA`; that of any other is focus."""
    return next((name for name, one in CRITERIA.items() if one is criterion), "focus")
