"""Sums of normal matrices: runs that scatter, priors, units of one type.

A run's normal matrix A and right-hand side b stand for exp(-(x' A x)/2 + b' x): what two runs say is their
sum.
"""

from typing import NamedTuple

import numpy as np

ROUNDS = 12
"""Of expectation and maximisation; each brings spreads some half of the way."""


def scattered(
    normal: np.ndarray, right: np.ndarray, directions: np.ndarray, variance: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What runs say of unknowns that each run has moved at random along directions, by Woodbury's identity.

    Args:
        normal: Shape (r, m, m).
        right: Shape (r, m).
        directions: Shape (k, m).
        variance: Of the amounts, shape (r, k) or (k,), above zero.
    """
    along = normal @ directions.T
    inner = directions @ along
    places = np.arange(len(directions))
    inner[:, places, places] += 1.0 / variance
    taken = np.linalg.solve(
        inner, np.concatenate([np.swapaxes(along, 1, 2), (right @ directions.T)[..., None]], 2)
    )
    less = along @ taken
    return normal - less[:, :, :-1], right - less[:, :, -1]


class Population(NamedTuple):
    """Arms of one type: mean (d,) and variance (d,) between units of each unknown, independent."""

    mean: np.ndarray
    variance: np.ndarray

    def posterior(self, normal: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean (d,) and covariance (d, d) of one unit of which runs say this."""
        precision = normal + np.diag(1.0 / self.variance)
        covariance = np.linalg.inv(precision)
        covariance = 0.5 * (covariance + covariance.T)
        return covariance @ (right + self.mean / self.variance), covariance


def population(normals: np.ndarray, rights: np.ndarray, before: Population) -> Population:
    """Mean and spread of units (a, d, d), (a, d), by empirical Bayes.

    What was held true before counts as one more unit.
    """
    found, units = before, len(normals)
    for _ in range(ROUNDS):
        means, covariances = zip(*map(found.posterior, normals, rights), strict=True)
        mean = (before.mean + np.sum(means, axis=0)) / (1 + units)
        square = np.square(means - mean) + np.diagonal(covariances, axis1=1, axis2=2)
        found = Population(mean, (before.variance + square.sum(axis=0)) / (1 + units))
    return found
