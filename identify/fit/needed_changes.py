r"""Standard parameters of a fit in which only what the data require differs from the nominal values.

A group of parameters, such as the body of a link, returns to its nominal values if the data do not exclude
them. Given that, the most probable values of the other parameters follow from the covariance:

.. math:: x_a' = x_a - C_{ag} C_{gg}^{-1} (x_g - x_g^0), \quad C_{aa}' = C_{aa} - C_{ag} C_{gg}^{-1} C_{ga}.

Groups return one after the other, the least significant first, since each changes the significance of others.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.stats import chi2

from ..effects import JointEffect
from ..model import Model
from .estimators.consistent import possible_body
from .fit import Fit
from .identified import Standard

SURE = 0.95
"""Probability with which no group differs from its nominal values by chance."""
SINGULAR = 1e-10
"""Relative eigenvalue of a covariance below which a direction counts as certain."""


def needed_changes(fit: Fit, standard: Standard, std: np.ndarray | None = None) -> Standard:
    """The standard parameters, with groups at their nominal values unless the data exclude these.

    Args:
        fit: The fit.
        standard: Its standard parameters, shape (p,).
        std: Additional standard deviations of the parameters, shape (p,).
    """
    values, covariance = standard.values.copy(), standard.covariance.copy()
    if std is not None:
        covariance += np.diag(std**2)
    unknown = np.isinf(np.diag(covariance))
    covariance[unknown, :] = covariance[:, unknown] = 0.0
    groups = [columns[~unknown[columns]] for columns in _groups(fit.model)]
    values, covariance = with_needed_changes(values, covariance, fit.model.nominal_values, groups)
    covariance[unknown, unknown] = np.inf
    for body in fit.model.inertias:  # values that move with those that return may leave what is possible
        values[body] = possible_body(values[body])
    return Standard(values, covariance)


def with_needed_changes(
    values: np.ndarray, covariance: np.ndarray, nominal: np.ndarray, groups: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Values and covariance given that insignificant groups of values are nominal.

    Args:
        values: Estimates, shape (p,).
        covariance: Their covariance, shape (p, p).
        nominal: Nominal values, shape (p,).
        groups: Indices of values that return together.
    """
    open_groups = [columns for columns in groups if len(columns)]
    level = 1.0 - (1.0 - SURE) / max(len(open_groups), 1)
    while open_groups:
        ratios = [
            _distance(values[columns] - nominal[columns], covariance[np.ix_(columns, columns)])
            / chi2.ppf(level, len(columns))
            for columns in open_groups
        ]
        least = int(np.argmin(ratios))
        if ratios[least] >= 1.0:
            break
        values, covariance = _returned(values, covariance, open_groups.pop(least), nominal)
    return values, covariance


def _groups(model: Model) -> Iterator[np.ndarray]:
    """Columns of parameters that change together: those of a link, or of one effect on one joint."""
    for effect, columns in zip(model.effects, model.columns, strict=True):
        places = np.arange(columns.start, columns.stop)
        if effect.of_links:
            yield from places.reshape(-1, 10)
        elif isinstance(effect, JointEffect) and len(places):
            yield from places.reshape(len(effect.columns(model.robot)), -1)
        else:
            yield places


def _distance(change: np.ndarray, covariance: np.ndarray) -> float:
    """Squared distance of a change from zero in standard deviations of all its directions."""
    return float(change @ _inverse(covariance) @ change)


def _inverse(covariance: np.ndarray) -> np.ndarray:
    """Inverse of a covariance; a certain direction counts as known to `SINGULAR` of the least certain one."""
    scale = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    sizes, directions = np.linalg.eigh(covariance / np.outer(scale, scale))
    sizes = np.maximum(sizes, SINGULAR * sizes[-1])
    return np.asarray((directions / sizes) @ directions.T / np.outer(scale, scale))


def _returned(
    values: np.ndarray, covariance: np.ndarray, columns: np.ndarray, nominal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Values and covariance given that a group has its nominal values."""
    gain = covariance[:, columns] @ _inverse(covariance[np.ix_(columns, columns)])
    values = values - gain @ (values[columns] - nominal[columns])
    covariance = covariance - gain @ covariance[columns, :]
    values[columns] = nominal[columns]
    covariance[columns, :] = covariance[:, columns] = 0.0
    return values, covariance
