r"""Weighted least squares with what was believed before as a prior.

Standard parameters are held to be :math:`\varphi_0 \pm T`. The data see base parameters
:math:`\chi = K \varphi` alone, so the prior is :math:`\chi \sim N(K \varphi_0, K T^2 K^T)`. It settles
what a motion cannot: a spring balancer against gravity over a short range of its joint, for instance.
"""

import numpy as np

from ..equations import Equations
from .compressed import Compressed, solve
from .covariance import sandwich
from .estimate import Estimate
from .least_squares import residual, weighted


def bayesian(equations: Equations) -> Estimate:
    """Most probable base parameters given data and beliefs."""
    compressed = Compressed.of(equations)
    start = weighted(equations)
    mean, deviation = prior(equations)
    whiten = np.linalg.inv(np.linalg.cholesky(deviation))
    noise, values = start.noise, start.values
    for _ in range(10):
        before = values
        rows = [compressed.regressor(j) / noise[j] for j in range(len(noise))]
        right = [compressed.torque(j, equations.gain) / noise[j] for j in range(len(noise))]
        values = solve(
            np.concatenate([*rows, whiten]), np.concatenate([*right, whiten @ mean]), equations.names
        )
        noise = compressed.residual_std(values, equations.gain)
        if np.linalg.norm(values - before) <= 1e-8 * np.linalg.norm(values):
            break
    data = sandwich(equations.regressor, residual(equations, values, equations.gain), equations)
    covariance = _both(data, deviation)
    full = np.pad(covariance, (0, len(equations.gain)))
    standard = standard_parameters(equations, values)
    return Estimate("bayesian", values, equations.gain, full, noise, standard)


def prior(equations: Equations) -> tuple[np.ndarray, np.ndarray]:
    """Mean (b,) and covariance (b, b) of the base parameters before the data."""
    regrouping, deviation = equations.base.regrouping, finite_tolerance(equations)
    spread = regrouping * deviation
    return regrouping @ equations.believed, spread @ spread.T


def finite_tolerance(equations: Equations) -> np.ndarray:
    """Standard deviation of each standard parameter; where nothing is held, one that says nothing.

    A thousand times what one unit of the column needs to make the whole measured torque.
    """
    torque = np.sqrt(np.sum((equations.gain * equations.current) ** 2))
    size = np.linalg.norm(equations.regressor, axis=(0, 1))
    loose = np.full(len(equations.tolerance), 1e3 * torque / np.min(size[size > 0]))
    loose[equations.base.kept] = 1e3 * torque / np.maximum(size, np.min(size[size > 0]))
    known = np.isfinite(equations.tolerance)
    # A believed zero with zero tolerance would make the prior singular; it is held to a billionth.
    return np.where(known, np.maximum(equations.tolerance, 1e-9 * loose), loose)


def standard_parameters(equations: Equations, values: np.ndarray) -> np.ndarray:
    """Most probable standard parameters (p,) for given base parameters (b,)."""
    spread = equations.base.regrouping * finite_tolerance(equations)
    mean = equations.base.regrouping @ equations.believed
    change = np.linalg.lstsq(spread, values - mean, rcond=None)[0]
    return equations.believed + finite_tolerance(equations) * change


def _both(data: np.ndarray, belief: np.ndarray) -> np.ndarray:
    """Covariance when independent data and belief are joined, scaled against rounding."""
    size = np.sqrt(np.diag(data))
    joined = np.linalg.inv(data / np.outer(size, size)) + np.linalg.inv(belief / np.outer(size, size))
    return np.linalg.inv(joined) * np.outer(size, size)
