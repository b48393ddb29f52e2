r"""Covariance of an estimate under coloured noise.

With weights :math:`1/\sigma_j^2` and rows :math:`J_j`, :math:`H = \sum_j J_j^T J_j / \sigma_j^2`, the
estimate's covariance is :math:`H^{-1} S H^{-1}`, where S is the covariance of the gradient,
:math:`S = \sum_{jk} J_j^T C_{jk} J_k / (\sigma_j \sigma_k)^2`, and C the noise's covariance over time
and joints: encoder noise of one joint is acceleration noise in the torque of several. C comes from a
vector autoregressive model of the residual and is applied in the frequency domain. White noise would
give :math:`H^{-1}`, which at the residuals of real arms claims intervals several times too short.
"""

from collections.abc import Iterator

import numpy as np

from ..equations import Equations
from ..noise import ORDER, NoiseModel, autocovariance, autoregression

SEGMENT = 2048
"""Rows that are transformed at once. Noise is forgotten within some tens of rows, so cutting a long run
here changes the result by about a per cent and bounds the memory."""


def noise_model(residual: np.ndarray, equations: Equations) -> NoiseModel:
    """Vector autoregressive model of the residual (r, n), rows with zero weight left out."""
    pieces = [residual[run] for run in equations.runs]
    weights = [equations.weight[run] for run in equations.runs]
    return autoregression(autocovariance(pieces, weights, ORDER))


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
    noise = noise_model(residual, equations)
    bread, meat = np.zeros((2, unknowns, unknowns))
    for rows in _segments(equations):
        factor = weight[rows, :, None] / variance[:, None] * scale
        moved = left[rows] * factor
        right = jacobian[rows] * (weight[rows, :, None] * scale)
        bread += moved.reshape(-1, unknowns).T @ right.reshape(-1, unknowns)
        meat += _coloured_gram(moved, noise)
    inverse = np.linalg.inv(bread)
    return inverse @ meat @ inverse.T * np.outer(scale, scale)


def _segments(equations: Equations) -> Iterator[slice]:
    for run in equations.runs:
        for start in range(run.start, run.stop, SEGMENT):
            yield slice(start, min(start + SEGMENT, run.stop))


def _coloured_gram(rows: np.ndarray, noise: NoiseModel) -> np.ndarray:
    """rows^T C rows, shape (k, k), for rows (r, n, k) and C the noise's covariance over rows and joints."""
    count = 2 * len(rows)  # zero padding keeps the ends from meeting
    transform = np.fft.rfft(rows, count, axis=0)
    roots = noise.roots(count)[: len(transform)]
    coloured = np.einsum("fij,fik->fjk", roots.conj(), transform, optimize=True)
    fold = np.full(len(transform), 2.0)
    fold[[0, -1]] = 1.0
    coloured *= np.sqrt(fold / count)[:, None, None]
    flat = coloured.reshape(-1, rows.shape[2])
    return flat.real.T @ flat.real + flat.imag.T @ flat.imag
