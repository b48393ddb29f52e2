r"""Least squares (ordinary, weighted, iteratively reweighted) and instrumental variables at nominal gains.

In a closed loop, the measured motion follows the torque noise, so regressor and noise are correlated and
least squares is biased. The commanded motion is independent of the noise; its regressor Z serves as
instrument: :math:`\hat\chi = (Z^T W)^{-1} Z^T \tau` (Janot, Vandanjon, Gautier 2014).
"""

import numpy as np

from ...errors import FitError
from ..equations import Equations
from .compressed import Compressed, Estimate, solve
from .covariance import sandwich
from .nominal_gains import of_nominal_gains

HUBER = 1.345
"""Residuals beyond this many standard deviations count less than quadratically: this gives 95 % efficiency on
Gaussian noise (Huber) and bounds the influence of a collision or a spike."""


def residual(equations: Equations, values: np.ndarray, gain: np.ndarray) -> np.ndarray:
    """Measured minus predicted torque, shape (r, n) [N m]."""
    return gain * equations.current - equations.known - equations.regressor @ values


def ordinary(equations: Equations) -> Estimate:
    """Ordinary least squares: all rows have the same weight, regardless of the joint's noise."""
    values, _ = _solution(equations, Compressed.of(equations), np.ones(len(equations.gain)))
    # Rows have unit weight, so the covariance divides all of them by one common standard deviation.
    return _estimate("ordinary", equations, values, common=True)


def weighted(equations: Equations) -> Estimate:
    """Weighted least squares: each joint's rows are divided by the standard deviation of its residual."""
    values, _ = weighted_solution(equations, Compressed.of(equations))
    return _estimate("weighted", equations, values)


def reweighted(equations: Equations) -> Estimate:
    """Iteratively reweighted least squares: `weighted` with Huber's weights for outliers."""
    huber = np.ones_like(equations.current)
    values = np.zeros(equations.regressor.shape[2])
    for _ in range(30):
        before = values
        values, noise = weighted_solution(equations, Compressed.of(equations, huber))
        size = np.abs(residual(equations, values, equations.gain)) / _robust_std(equations, values)
        huber = np.minimum(1.0, HUBER / np.maximum(size, 1e-12))
        if np.linalg.norm(values - before) <= 1e-6 * np.linalg.norm(values):
            break
    return _estimate("reweighted", equations, values, huber=huber)


def _robust_std(equations: Equations, values: np.ndarray) -> np.ndarray:
    """Standard deviation of each joint's residual from its median absolute value, shape (n,)."""
    sizes = np.abs(residual(equations, values, equations.gain))
    sliding = [sizes[equations.weight[:, j] > 0, j] for j in range(sizes.shape[1])]
    return np.maximum([1.4826 * np.median(s) for s in sliding], 1e-300)


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


def _estimate(
    method: str,
    equations: Equations,
    values: np.ndarray,
    common: bool = False,
    huber: np.ndarray | None = None,
) -> Estimate:
    remaining, torque = residual(equations, values, equations.gain), equations.gain * equations.current
    noise = Compressed.of(equations).residual_std(values, equations.gain)
    jacobian, instruments = equations.regressor, None
    if common:  # the sandwich divides rows by each joint's variance; ordinary least squares does not
        instruments = equations.regressor * (noise**2)[None, :, None]
    if huber is not None:  # the influence of an outlier is bounded, so its derivative is zero
        remaining, instruments = remaining * huber, equations.regressor
        jacobian, torque = equations.regressor * (huber == 1.0)[:, :, None], torque * (huber == 1.0)
    spread = sandwich(jacobian, remaining, equations, instruments, torque=torque)
    covariance = of_nominal_gains(spread, equations)
    return Estimate(method, values, equations.gain, covariance, noise, nominal_gains=True)


def instrumental(equations: Equations) -> Estimate:
    """Instrumental variables with the commanded motion, joints weighted by their noise.

    Raises:
        FitError: The runs hold no commanded positions.
    """
    if equations.commanded is None:
        raise FitError(
            "instrumental variables need the commanded positions in every run; "
            "record them, or use the 'weighted' estimator"
        )
    start = weighted(equations)
    noise, commanded = start.noise, equations.commanded()
    instrument = commanded * equations.weight[:, :, None]
    values = start.values
    for _ in range(5):
        scaled = instrument / noise[None, :, None] ** 2
        normal = np.einsum("rnb,rnc->bc", scaled, equations.regressor)
        torque = equations.gain * equations.current - equations.known
        size = np.sqrt(np.abs(np.diag(normal)))
        right = np.einsum("rnb,rn->b", scaled, torque)
        values = np.linalg.solve(normal / np.outer(size, size), right / size) / size
        remaining = residual(equations, values, equations.gain)
        noise = np.sqrt(np.sum(equations.weight * remaining**2, axis=0) / equations.weight.sum(axis=0))
    covariance = of_nominal_gains(
        sandwich(equations.regressor, remaining, equations, commanded, torque=torque), equations
    )
    return Estimate("instrumental", values, equations.gain, covariance, noise, nominal_gains=True)
