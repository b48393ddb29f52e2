"""Estimate: what every estimator returns."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..equations import Equations


@dataclass(frozen=True)
class Estimate:
    """Values with their uncertainty.

    Attributes:
        method: Name of the estimator.
        values: Base parameters, shape (b,).
        gain: Torque per unit of current, shape (n,); nominal where the method does not estimate it.
        covariance: Of values, then gains, shape (b + n, b + n); zero for what was not estimated.
        noise: Standard deviation of the residual of each joint, shape (n,) [N m].
        standard: Standard parameters, shape (p,), where the method finds them.
    """

    method: str
    values: np.ndarray
    gain: np.ndarray
    covariance: np.ndarray
    noise: np.ndarray
    standard: np.ndarray | None = None

    @property
    def std(self) -> np.ndarray:
        """Standard deviation of the base parameters, shape (b,)."""
        return np.sqrt(np.diag(self.covariance)[: len(self.values)])

    @property
    def gain_std(self) -> np.ndarray:
        """Standard deviation of the drive gains, shape (n,)."""
        return np.sqrt(np.diag(self.covariance)[len(self.values) :])


Estimator = Callable[[Equations], Estimate]
