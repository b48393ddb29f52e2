r"""Covariance of an estimate under coloured noise.

With weights :math:`1/\sigma_j^2` and rows :math:`J_j`, :math:`H = \sum_j J_j^T J_j / \sigma_j^2`, the
estimate's covariance is :math:`H^{-1} S H^{-1}`, where S is the covariance of the gradient,
:math:`S = \sum_{jk} J_j^T C_{jk} J_k / (\sigma_j \sigma_k)^2`, and C the noise's covariance over time
and joints: encoder noise of one joint is acceleration noise in the torque of several. C comes from the
residual's autocovariances and is applied in the frequency domain. White noise would give
:math:`H^{-1}`, which at the residuals of real arms claims intervals several times too short.
"""

from collections.abc import Iterator

import numpy as np

from ..equations import Equations
from ..noise import autocovariance, spectrum

SEGMENT = 2048
"""Rows that are transformed at once. Noise is forgotten within some tens of rows, so cutting a long run
here changes the result by about a per cent and bounds the memory."""


MEMORY = 2.0
"""Longest lag [s] of the residual's autocovariance that counts: several times what noise and the misfit of
friction around a reversal remember, since Parzen's window takes a tenth off at an eighth of it."""


def noise_covariance(residual: np.ndarray, equations: Equations) -> np.ndarray:
    """Autocovariance of the residual (r, n) up to `MEMORY`, rows with zero weight left out."""
    pieces = [residual[run] for run in equations.runs]
    weights = [equations.weight[run] for run in equations.runs]
    lags = max(4, int(MEMORY * equations.rate))
    return autocovariance(pieces, weights, lags)


def sandwich(
    jacobian: np.ndarray,
    residual: np.ndarray,
    equations: Equations,
    left: np.ndarray | None = None,
) -> np.ndarray:
    """Covariance of the solution of weighted least squares with rows `jacobian`.

    Args:
        jacobian: Derivative of the prediction by the unknowns, shape (r, n, k), in the residual's unit.
        residual: Shape (r, n).
        equations: Weights and runs.
        left: Instruments in place of the transposed rows, shape (r, n, k).

    Returns:
        Shape (k, k).
    """
    weight = equations.weight
    unknowns, joints = jacobian.shape[2], jacobian.shape[1]
    left = jacobian if left is None else left
    # Fitting k unknowns shortens the residual; each joint is charged its share.
    counts = weight.sum(axis=0)
    freedom = np.maximum(counts - unknowns / joints, 1.0)
    residual = residual * np.sqrt(counts / freedom)
    variance = np.sum(weight * residual**2, axis=0) / counts
    # A joint that the model meets exactly (a channel that is zero throughout) would outweigh all others
    # beyond double precision.
    variance = np.maximum(variance, 1e-12 * np.max(variance) + np.finfo(float).tiny)
    scale = 1.0 / np.sqrt(np.einsum("rnk,rnk,rn->k", left, left, weight / variance, optimize=True))
    noise = noise_covariance(residual, equations)
    bread, meat = np.zeros((2, unknowns, unknowns))
    for rows in _segments(equations):
        factor = weight[rows, :, None] / variance[:, None] * scale
        moved = left[rows] * factor
        right = jacobian[rows] * (weight[rows, :, None] * scale)
        bread += moved.reshape(-1, unknowns).T @ right.reshape(-1, unknowns)
        meat += _coloured_gram(moved, noise)
    inverse = np.linalg.inv(bread)
    return inverse @ meat @ inverse.T * np.outer(scale, scale)


def sandwich_with_gains(equations: Equations, values: np.ndarray, gain: np.ndarray) -> np.ndarray:
    """Covariance of (values, gains), shape (b + n, b + n), where currents are what is predicted."""
    torque = equations.regressor @ values + equations.known
    by_gain = -np.eye(len(gain)) * (torque / gain**2)[:, :, None]
    jacobian = np.concatenate([equations.regressor / gain[None, :, None], by_gain], axis=2)
    return sandwich(jacobian, equations.current - torque / gain, equations)


def _segments(equations: Equations) -> Iterator[slice]:
    for run in equations.runs:
        for start in range(run.start, run.stop, SEGMENT):
            yield slice(start, min(start + SEGMENT, run.stop))


def _coloured_gram(rows: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """rows^T C rows, shape (k, k), for rows (r, n, k) and C made of the noise's autocovariances."""
    density = spectrum(noise, 2 * len(rows))  # zero padding keeps the ends from meeting
    count, unknowns = len(density), rows.shape[2]
    transform = np.fft.rfft(rows, count, axis=0)
    fold = np.full(len(transform), 2.0)
    fold[0] = 1.0
    if count % 2 == 0:
        fold[-1] = 1.0
    coloured = np.matmul(density[: len(transform)] * (fold / count)[:, None, None], transform)
    return (transform.reshape(-1, unknowns).conj().T @ coloured.reshape(-1, unknowns)).real
