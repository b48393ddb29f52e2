r"""Weighted least squares at nominal gains, and what tolerances of nominal values do to an estimate.

Errors of nominal drive gains are errors of the estimate. Its covariance is therefore that of values and gains
together, with the stated tolerance of the gains, so that every interval includes that tolerance.

The prior of the standard parameters is :math:`\varphi_0 \pm T`. The data depend only on the base parameters
:math:`\chi = K \varphi`, so their prior is :math:`\chi \sim N(K \varphi_0, K T^2 K^T)`. It resolves what a
motion cannot, such as a spring balancer against gravity over a short range of the joint.
"""

import numpy as np

from ..equations import Equations
from .compressed import Compressed, Estimate, solve
from .covariance import sandwich


def residual(equations: Equations, values: np.ndarray, gain: np.ndarray) -> np.ndarray:
    """Measured minus predicted torque, shape (r, n) [N m]."""
    return gain * equations.current - equations.known - equations.regressor @ values


def weighted(equations: Equations) -> Estimate:
    """Weighted least squares: each joint's rows are divided by the standard deviation of its residual."""
    compressed = Compressed.of(equations)
    values, _ = weighted_solution(equations, compressed)
    remaining, torque = residual(equations, values, equations.gain), equations.gain * equations.current
    spread = sandwich(equations.regressor, remaining, equations, torque=torque)
    by_gain, deviation = spread.by_scale / equations.gain, gain_deviation(equations)
    covariance = with_nominal_gains(spread.covariance, by_gain, deviation)
    noise = compressed.residual_std(values, equations.gain)
    return Estimate("weighted", values, equations.gain, covariance, noise, nominal_gains=True)


def weighted_solution(equations: Equations, compressed: Compressed) -> tuple[np.ndarray, np.ndarray]:
    """Values (b,) and noise (n,) [N m] of `weighted`, iterated until they are consistent."""
    noise = np.ones(len(equations.gain))
    values = np.zeros(equations.regressor.shape[2])
    for _ in range(20):
        before = values
        values, noise = _solution(equations, compressed, noise)
        if np.linalg.norm(values - before) <= 1e-8 * np.linalg.norm(values):
            break
    return values, noise


def _solution(
    equations: Equations, compressed: Compressed, noise: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    joints = range(len(noise))
    rows = np.concatenate([compressed.regressor(j) / noise[j] for j in joints])
    right = np.concatenate([compressed.torque(j, equations.gain) / noise[j] for j in joints])
    values = solve(rows, right, equations.names)
    noise_std = compressed.residual_std(values, equations.gain)
    return values, np.maximum(noise_std, 1e-9 * np.max(noise_std) + 1e-300)


def gain_deviation(equations: Equations) -> np.ndarray:
    """Standard deviation of the nominal gains, shape (n,); zero if gains are not stated or not needed."""
    if np.all(equations.gain == 1.0):  # torque was recorded, or currents without stated gains
        return np.zeros(len(equations.gain))
    return np.abs(equations.gain) * equations.gain_tolerance


def with_nominal_gains(covariance: np.ndarray, by_gain: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Covariance (b + n, b + n) of values, then nominal gains with independent errors.

    Args:
        covariance: Covariance of the values at exact gains, shape (b, b).
        by_gain: Change of each value with each gain, shape (b, n).
        deviation: Standard deviation of each gain, shape (n,).
    """
    spread = np.concatenate([by_gain, np.eye(len(deviation))]) * deviation
    return np.pad(covariance, (0, len(deviation))) + spread @ spread.T


def given_nominal(estimate: Estimate) -> np.ndarray:
    """Covariance (b, b) of the values; nominal gains, if the estimate uses them, count as exact."""
    return given_gains(estimate, np.full(len(estimate.gain), estimate.nominal_gains))


def given_gains(estimate: Estimate, exact: np.ndarray) -> np.ndarray:
    """Covariance (b, b) of the base values if the gains selected by `exact`, shape (n,), were known."""
    count = len(estimate.values)
    marginal = estimate.covariance[:count, :count]
    if not np.any(exact & (estimate.gain_std > 0.0)):
        return np.array(marginal)
    by_gain = slope(estimate, exact)
    conditional = marginal - by_gain @ estimate.covariance[count:, count:] @ by_gain.T
    conditional = 0.5 * (conditional + conditional.T)
    floor = np.finfo(float).eps * np.diag(marginal)
    conditional[np.diag_indices(count)] = np.maximum(np.diag(conditional), floor)
    return conditional


def slope(estimate: Estimate, selected: np.ndarray | None = None) -> np.ndarray:
    """Change of each base value with each gain, or with the selected gains, shape (b, n).

    The change is zero for gains without uncertainty.
    """
    count, std = len(estimate.values), estimate.gain_std
    change = np.zeros((count, len(std)))
    uncertain = std > 0.0 if selected is None else (std > 0.0) & selected
    if (known := np.flatnonzero(uncertain)).size:
        scaled = estimate.covariance[:count, count + known] / std[known]
        gains = estimate.covariance[np.ix_(count + known, count + known)]
        correlation = gains / np.outer(std[known], std[known])
        change[:, known] = np.linalg.lstsq(correlation, scaled.T, rcond=None)[0].T / std[known]
    return change


def prior(equations: Equations) -> tuple[np.ndarray, np.ndarray]:
    """Mean (b,) and covariance (b, b) of the prior of the base parameters."""
    regrouping, deviation = equations.base.regrouping, finite_tolerance(equations)
    spread = regrouping * deviation
    return regrouping @ equations.nominal, spread @ spread.T


LOOSE = 10.0
"""Standard deviation for a parameter without a prior, over the value that alone would explain the whole
measured torque: wide enough to have no effect, and no wider, since rounding errors grow with it."""


def finite_tolerance(equations: Equations) -> np.ndarray:
    """Prior standard deviation of each standard parameter, shape (p,); finite even without a prior."""
    torque = np.linalg.norm((equations.gain * equations.current)[equations.weight > 0])
    rows = (equations.regressor * equations.weight[:, :, None]).reshape(-1, len(equations.names))
    # A regrouped column is a combination of base columns; the norm of an unobservable column is zero.
    regrouping = equations.base.regrouping
    size = np.sqrt(np.einsum("bp,bc,cp->p", regrouping, rows.T @ rows, regrouping, optimize=True))
    seen = size > 0
    loose = LOOSE * torque / np.where(seen, size, np.median(size[seen]))
    # A nominal zero with zero tolerance would make the prior singular; it gets a tiny tolerance instead.
    return np.where(np.isfinite(equations.tolerance), np.maximum(equations.tolerance, 1e-9 * loose), loose)
