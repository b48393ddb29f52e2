r"""Covariance of an estimate under colored noise.

With weights :math:`1/\sigma_j^2` and rows :math:`J_j`, :math:`H = \sum_j J_j^T J_j / \sigma_j^2`, the
covariance of the estimate is :math:`H^{-1} S H^{-1}`. S is the covariance of the gradient,
:math:`S = \sum_{jk} J_j^T C_{jk} J_k / (\sigma_j \sigma_k)^2`, and C is the covariance of the noise over time
and joints: encoder noise of one joint is acceleration noise in the torque of several. C is computed from the
autocovariances of the residual and applied in the frequency domain. Assuming white noise would give
:math:`H^{-1}`, whose intervals are several times too narrow for the residuals of real arms.

This holds for a residual that is stationary over a run. Model errors are not: they occur where a joint moves
slowly or is far from its middle position. `block_scatter` therefore adds the scatter between blocks of time.

Nominal drive gains are uncertain by their tolerance. A relative error :math:`\delta_j` adds :math:`\delta_j`
times the measured torque of joint j to the fitted torque and changes the estimate by
:math:`\delta_j\,\partial\beta/\partial\delta_j`, the solution for that torque alone; see
`with_nominal_gains`.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...preparation.repeated_motion import repeated_share
from ..equations import Equations
from .colored_noise import noise_covariance, spectrum

SEGMENT = 2048
"""Rows per Fourier transform. Noise is correlated over a few tens of rows, so splitting a long run changes
the result by about one percent and limits the memory."""


class Spread(NamedTuple):
    """Scatter of an estimate."""

    covariance: np.ndarray  # covariance that noise and model errors cause, shape (k, k)
    # Change of each unknown per relative error of each joint's measured torque, shape (k, n).
    by_scale: np.ndarray


def sandwich(
    jacobian: np.ndarray,
    residual: np.ndarray,
    equations: Equations,
    instruments: np.ndarray | None = None,
    before: np.ndarray | None = None,
    torque: np.ndarray | None = None,
) -> Spread:
    """Scatter of a weighted least-squares solution, from the sandwich formula of this module.

    Args:
        jacobian: Derivative of the prediction with respect to the unknowns, shape (r, n, k).
        residual: Measured minus predicted values, in the unit of the prediction, shape (r, n).
        equations: Equations with weights and runs.
        instruments: Instruments that replace the transposed Jacobian, shape (r, n, k).
        before: Inverse prior variance of each unknown, shape (k,); zero by default.
        torque: Measured torque that a scale error of each joint multiplies, shape (r, n); zero by default.
    """
    weight, unknowns = equations.weight, jacobian.shape[2]
    instruments = jacobian if instruments is None else instruments
    torque = np.zeros_like(residual) if torque is None else torque
    variance = np.sum(weight * residual**2, axis=0) / weight.sum(axis=0)
    # A joint with zero residual (a channel that is always zero) would outweigh all others beyond double
    # precision.
    variance = np.maximum(variance, 1e-12 * np.max(variance) + np.finfo(float).tiny)
    scale = 1.0 / np.sqrt(
        np.einsum("rnk,rnk,rn->k", instruments, instruments, weight / variance, optimize=True)
    )
    deviation = np.sqrt(variance)[:, None]

    prior = np.zeros(unknowns) if before is None else before * scale**2
    all_blocks = [rows for run in equations.runs for rows in blocks(run, equations.rate)]

    def weighted_rows(array: np.ndarray, rows: slice) -> np.ndarray:
        return array[rows] * (weight[rows, :, None] / deviation * scale)

    # In the directions of this root the information is one, which keeps the digits that sums of squares lose
    # where rows hardly determine a sum of unknowns.
    root = inverse_root(sum((_gram(weighted_rows(jacobian, rows)) for rows in all_blocks), np.diag(prior)))

    def whitened(array: np.ndarray, rows: slice) -> np.ndarray:
        return weighted_rows(array, rows) @ root

    # What repeats in each lap of a motion is not new evidence.
    once = np.sqrt(repeated_share(weight * residual, equations.first))
    parts = [
        _part(
            whitened(instruments, rows),
            whitened(jacobian, rows),
            residual[rows] / (deviation[:, 0] * once),
            torque[rows] / deviation[:, 0],
        )
        for rows in all_blocks
    ]
    sums = _Part(*(np.sum(terms, axis=0) for terms in zip(*parts, strict=True)))
    meat = root.T * prior @ root
    bread, information = sums.bread + meat, sums.information + meat
    # The noise level differs between runs: with a payload, currents and their noise are larger. The noise
    # color is that of the drives and encoders, the same in all runs; a short run could not determine its own.
    levels = [_level(residual[run], weight[run], deviation[:, 0]) for run in equations.runs]
    scaled = np.concatenate(
        [residual[run] / level for run, level in zip(equations.runs, levels, strict=True)]
    )
    color = noise_covariance(scaled, equations)
    for run, level in zip(equations.runs, levels, strict=True):
        noise = color * np.outer(level / once, level / once)
        for start in range(run.start, run.stop, SEGMENT):
            rows = slice(start, min(start + SEGMENT, run.stop))
            absorbed = _absorbed_power(whitened(jacobian, rows), len(noise) - 1)
            meat = meat + _colored_gram(whitened(instruments, rows) / deviation, noise, absorbed)
    inverse = scale[:, None] * root @ np.linalg.inv(bread)
    covariance = inverse @ meat @ inverse.T
    moved = between_blocks([p.gradient for p in parts], [p.information for p in parts], information)
    longer = longer_by(covariance, inverse @ moved)
    return Spread(covariance * np.outer(longer, longer), inverse @ sums.by_scale)


def _gram(rows: np.ndarray) -> np.ndarray:
    """Products (k, k) of rows (r, n, k) with each other."""
    flat = rows.reshape(-1, rows.shape[2])
    return flat.T @ flat


class _Part(NamedTuple):
    """Contribution of one block of time to the sums over all rows."""

    bread: np.ndarray  # instruments times Jacobian, shape (k, k)
    information: np.ndarray  # Jacobian times Jacobian, shape (k, k)
    gradient: np.ndarray  # instruments times residual, shape (k,)
    by_scale: np.ndarray  # instruments times each joint's torque, shape (k, n)


def _part(instruments: np.ndarray, jacobian: np.ndarray, residual: np.ndarray, torque: np.ndarray) -> _Part:
    """Sums over instruments and Jacobian (r, n, k), residual and torque (r, n), all divided by the noise."""
    unknowns = instruments.shape[2]
    transposed, rows = instruments.reshape(-1, unknowns), jacobian.reshape(-1, unknowns)
    by_scale = np.einsum("rnk,rn->kn", instruments, torque)
    return _Part(transposed.T @ rows, rows.T @ rows, transposed.T @ residual.ravel(), by_scale)


def _level(residual: np.ndarray, weight: np.ndarray, usual: np.ndarray) -> np.ndarray:
    """Residual rms of each joint in one run, shape (n,); `usual` for a joint that sticks throughout."""
    counts = weight.sum(axis=0)
    square = np.sum(weight * residual**2, axis=0) / np.maximum(counts, 1.0)
    return np.where(counts > 0, np.maximum(np.sqrt(square), 1e-6 * usual), usual)


def _absorbed_power(hat: np.ndarray, lags: int) -> np.ndarray:
    """Share of the noise power that the fit absorbed, by frequency, shape (count, n).

    The squared norm of row t of `hat` (r, n, k) is the leverage of sample t. The unknowns follow the noise at
    the low frequencies of their columns, where the residual is therefore smaller than the noise.
    """
    count = 2 * len(hat)
    power = np.sum(np.abs(np.fft.rfft(hat, count, axis=0)) ** 2, axis=2)
    leverage = np.fft.irfft(power, count, axis=0)[: lags + 1] / len(hat)
    leverage = np.pad(leverage, ((0, lags + 1 - len(leverage)), (0, 0)))
    density = spectrum(leverage[:, :, None] * np.eye(hat.shape[1]), count)
    return np.clip(np.diagonal(density, axis1=1, axis2=2).real, 0.0, 0.9)


def sandwich_with_gains(
    equations: Equations, values: np.ndarray, gain: np.ndarray, wide: np.ndarray
) -> np.ndarray:
    """Covariance of (values, gains), shape (b + n, b + n), for a model that predicts currents.

    `wide` is the prior standard deviation of each gain, shape (n,).
    """
    torque = equations.regressor @ values + equations.known
    by_gain = -np.eye(len(gain)) * (torque / gain**2)[:, :, None]
    jacobian = np.concatenate([equations.regressor / gain[None, :, None], by_gain], axis=2)
    before = np.concatenate([np.zeros(len(values)), wide**-2.0])
    return sandwich(jacobian, equations.current - torque / gain, equations, before=before).covariance


def _colored_gram(rows: np.ndarray, noise: np.ndarray, absorbed: np.ndarray) -> np.ndarray:
    """rows^T C rows, shape (k, k), for rows (r, n, k) and C from the residual's autocovariances.

    The residual power is corrected for the share that the fit absorbed, shape (count, n), to recover the
    noise.
    """
    density = spectrum(noise, 2 * len(rows))  # zero padding keeps the ends from meeting
    count, unknowns = len(density), rows.shape[2]
    transform = np.fft.rfft(rows, count, axis=0)
    half = len(transform)
    fold = np.full(half, 2.0)
    fold[0] = 1.0
    if count % 2 == 0:
        fold[-1] = 1.0
    raised = np.sqrt(fold[:, None] / count / (1.0 - absorbed[:half]))
    colored = np.matmul(density[:half] * raised[:, :, None] * raised[:, None, :], transform)
    return (transform.reshape(-1, unknowns).conj().T @ colored.reshape(-1, unknowns)).real


BLOCK = 1.0
"""Duration of a block [s]: longer than most correlation of noise and residual, and short enough that a run of
twenty seconds has enough blocks."""
SHORTEST = 10
"""Minimum number of rows in a block; at a low row rate, blocks last longer."""
FEWEST_BLOCKS = 20
"""Minimum number of blocks for a scatter estimate: twenty give a standard deviation to within a sixth."""
MOST_TAKEN = 0.9
"""Largest share of a block's scatter that the fit can absorb; beyond it, the residual carries no information
on the noise."""


def blocks(run: slice, rate: float) -> list[slice]:
    """Blocks of one run, each about `BLOCK` seconds long."""
    count = max(1, round((run.stop - run.start) / max(BLOCK * rate, SHORTEST)))
    edges = np.linspace(run.start, run.stop, count + 1).astype(int)
    return [slice(int(a), int(b)) for a, b in zip(edges[:-1], edges[1:], strict=True)]


def between_blocks(
    gradients: Sequence[np.ndarray], grams: Sequence[np.ndarray], information: np.ndarray
) -> np.ndarray:
    """Gradients of all blocks, shape (k, m), corrected for the variance that the fit has absorbed.

    The fit makes the gradients of all blocks add up to zero. A block with a share M of the information
    loses M of its variance, so its gradient is scaled by (1 - M)^(-1/2) (the correction CR2 of Bell and
    McCaffrey 2002). For m equal blocks and one unknown, that is the usual m / (m - 1).

    Args:
        gradients: Gradient of each block, shape (k,).
        grams: Information matrix of each block, shape (k, k).
        information: Information matrix of all blocks and of the prior, shape (k, k).
    """
    root = inverse_root(information)
    corrected = []
    for gradient, gram in zip(gradients, grams, strict=True):
        share, axes = np.linalg.eigh(root.T @ gram @ root)
        more = 1.0 / np.sqrt(1.0 - np.clip(share, 0.0, MOST_TAKEN)) - 1.0
        corrected.append(gradient + information @ root @ (axes @ (more * (axes.T @ (root.T @ gradient)))))
    return np.array(corrected).T


def longer_by(covariance: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Factors, shape (k,), by which scatter between blocks exceeds each standard deviation, if significantly.

    A few tens of blocks give a variance to within a fifth, but no covariance of more unknowns than blocks.
    Correlations therefore stay those of the noise, which is also the lower bound of the scatter.

    Args:
        covariance: Covariance that the noise causes, shape (k, k).
        moved: Change of each unknown by each block, shape (k, m).
    """
    variance = np.diag(covariance)
    if moved.shape[1] < FEWEST_BLOCKS:
        return np.ones(len(variance))
    ratio = np.divide(np.sum(moved**2, axis=1), variance, out=np.ones_like(variance), where=variance > 0.0)
    chance = np.sqrt(2.0 / moved.shape[1])  # relative std of a variance estimated from m normal samples
    return np.sqrt(np.where(ratio > 1.0 + chance, ratio, 1.0))


def inverse_root(matrix: np.ndarray) -> np.ndarray:
    """Matrix R with R R^T = inverse of a positive definite matrix (k, k), guarded against rounding."""
    size, vectors = np.linalg.eigh(matrix)
    return vectors / np.sqrt(np.maximum(size, np.finfo(float).eps * size[-1]))
