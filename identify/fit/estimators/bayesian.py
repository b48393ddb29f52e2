r"""Weighted least squares with a prior.

Standard parameters are held to be :math:`\varphi_0 \pm T`. The data see base parameters
:math:`\chi = K \varphi` alone, so the prior is :math:`\chi \sim N(K \varphi_0, K T^2 K^T)`. It settles
what a motion cannot: a spring balancer against gravity over a short range of its joint, for instance.
"""

import numpy as np

from ...positive_definite import factored, solve
from ..equations import Equations
from .compressed import Compressed
from .estimate import Estimate
from .least_squares import weighted


def bayesian(equations: Equations) -> Estimate:
    """Most probable base parameters given data and priors.

    The data enter with the covariance of coloured noise: weights as if it were white would trust the
    data several times too much against the priors.
    """
    data = weighted(equations)
    count = len(data.values)
    values, covariance = joined(data.values, data.covariance[:count, :count], *prior(equations))
    noise = Compressed.of(equations).residual_std(values, equations.gain)
    full = np.pad(covariance, (0, len(equations.gain)))
    standard = standard_parameters(equations, values)
    return Estimate("bayesian", values, equations.gain, full, noise, standard)


def joined(
    values: np.ndarray, covariance: np.ndarray, mean: np.ndarray, deviation: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Mean (b,) and covariance (b, b) when two independent ones are joined, scaled against rounding."""
    total = covariance + deviation
    share = solve(factored(total), covariance).T  # Kalman's gain
    both = share @ deviation
    return values + share @ (mean - values), 0.5 * (both + both.T)


def prior(equations: Equations) -> tuple[np.ndarray, np.ndarray]:
    """Mean (b,) and covariance (b, b) of the base parameters before the data."""
    regrouping, deviation = equations.base.regrouping, finite_tolerance(equations)
    spread = regrouping * deviation
    return regrouping @ equations.nominal, spread @ spread.T


LOOSE = 10.0
"""Deviation of what has no prior, over what would make the whole measured torque alone: wide
enough to have no effect, and no wider, since rounding grows with it."""


def finite_tolerance(equations: Equations) -> np.ndarray:
    """Standard deviation of each standard parameter, shape (p,), finite also where nothing is held."""
    torque = np.linalg.norm((equations.gain * equations.current)[equations.weight > 0])
    rows = (equations.regressor * equations.weight[:, :, None]).reshape(-1, len(equations.names))
    # A column that was regrouped is this combination of the kept ones; unseen columns have no length.
    regrouping = equations.base.regrouping
    size = np.sqrt(np.einsum("bp,bc,cp->p", regrouping, rows.T @ rows, regrouping, optimize=True))
    seen = size > 0
    loose = LOOSE * torque / np.where(seen, size, np.median(size[seen]))
    # A nominal zero with zero tolerance would make the prior singular; it is held to a billionth.
    return np.where(np.isfinite(equations.tolerance), np.maximum(equations.tolerance, 1e-9 * loose), loose)


def standard_parameters(equations: Equations, values: np.ndarray) -> np.ndarray:
    """Most probable standard parameters (p,) for given base parameters (b,)."""
    spread = equations.base.regrouping * finite_tolerance(equations)
    mean = equations.base.regrouping @ equations.nominal
    change = np.linalg.lstsq(spread, values - mean, rcond=None)[0]
    return equations.nominal + finite_tolerance(equations) * change
