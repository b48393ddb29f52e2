"""Weighted least squares at nominal gains."""

import numpy as np

from ..equations import Equations
from .compressed import Compressed, Estimate, solve
from .covariance import sandwich
from .nominal_gains import gain_deviation, with_nominal_gains


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
