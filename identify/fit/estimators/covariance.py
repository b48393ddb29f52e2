r"""Covariance of an estimate under coloured noise.

With weights :math:`1/\sigma_j^2` and rows :math:`J_j`, :math:`H = \sum_j J_j^T J_j / \sigma_j^2`, the
estimate's covariance is :math:`H^{-1} S H^{-1}`, where S is the covariance of the gradient,
:math:`S = \sum_{jk} J_j^T C_{jk} J_k / (\sigma_j \sigma_k)^2`, and C the noise's covariance over time
and joints: encoder noise of one joint is acceleration noise in the torque of several. C comes from the
residual's autocovariances and is applied in the frequency domain. White noise would give
:math:`H^{-1}`, which at the residuals of real arms claims intervals several times too short.

That holds for a residual that is alike throughout a run. What a model lacks is not: it comes where a joint
is slow, or far out. `blocks` therefore compares with the scatter of the gradient between blocks of time.

Nominal drive gains are wrong by their tolerance. A relative error :math:`\delta_j` adds the measured torque
of joint j times :math:`\delta_j` to what is fitted, so that it moves the estimate by
:math:`\partial\beta/\partial\delta_j`, the solution for that torque alone: see `with_nominal_gains`.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...preparation.noise import autocovariance, spectrum
from ..equations import Equations

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


class Spread(NamedTuple):
    """How an estimate scatters.

    Attributes:
        covariance: By the noise, and by what the model lacks, shape (k, k).
        by_scale: Change of each unknown with the relative error of each joint's measured torque, (k, n).
    """

    covariance: np.ndarray
    by_scale: np.ndarray


def sandwich(
    jacobian: np.ndarray,
    residual: np.ndarray,
    equations: Equations,
    left: np.ndarray | None = None,
    before: np.ndarray | None = None,
    torque: np.ndarray | None = None,
) -> Spread:
    """How the solution of weighted least squares with rows `jacobian` scatters.

    Args:
        jacobian: Derivative of the prediction by the unknowns, shape (r, n, k), in the residual's unit.
        residual: Shape (r, n).
        equations: Weights and runs.
        left: Instruments in place of the transposed rows, shape (r, n, k).
        before: Inverse variance of each unknown before the data, shape (k,); zero by default.
        torque: What a relative error of each joint's scale is one of, shape (r, n); zero by default.
    """
    weight, unknowns = equations.weight, jacobian.shape[2]
    left = jacobian if left is None else left
    torque = np.zeros_like(residual) if torque is None else torque
    variance = np.sum(weight * residual**2, axis=0) / weight.sum(axis=0)
    # A joint that the model meets exactly (a channel that is zero throughout) would outweigh all others
    # beyond double precision.
    variance = np.maximum(variance, 1e-12 * np.max(variance) + np.finfo(float).tiny)
    scale = 1.0 / np.sqrt(np.einsum("rnk,rnk,rn->k", left, left, weight / variance, optimize=True))
    deviation = np.sqrt(variance)[:, None]

    def weighted_rows(of: np.ndarray, rows: slice) -> np.ndarray:
        return of[rows] * (weight[rows, :, None] / deviation * scale)

    held = np.zeros(unknowns) if before is None else before * scale**2
    bread, information, meat = np.stack([np.diag(held)] * 3)
    by_scale, gradients, grams = np.zeros((unknowns, torque.shape[1])), [], []
    for run in equations.runs:
        for rows in blocks(run, equations.rate):
            moved, right = (weighted_rows(of, rows) for of in (left, jacobian))
            gram = np.einsum("rnk,rnl->kl", right, right, optimize=True)
            bread += np.einsum("rnk,rnl->kl", moved, right, optimize=True)
            information += gram
            grams.append(gram)
            gradients.append(np.einsum("rnk,rn->k", moved, residual[rows] / deviation[:, 0]))
            by_scale += np.einsum("rnk,rn->kn", moved, torque[rows] / deviation[:, 0])
    root = _inverse_root(information)
    # Noise differs in level between runs: under a payload currents, and so their noise, are larger. Its
    # colour is that of the same drives and encoders, and a short run could not give its own.
    levels = [_level(residual[run], weight[run], deviation[:, 0]) for run in equations.runs]
    even = np.concatenate([residual[run] / level for run, level in zip(equations.runs, levels, strict=True)])
    colour = noise_covariance(even, equations)
    for run, level in zip(equations.runs, levels, strict=True):
        noise = colour * np.outer(level, level)
        for rows in _segments(run):
            taken = _taken(weighted_rows(jacobian, rows) @ root, len(noise) - 1)
            meat += _coloured_gram(weighted_rows(left, rows) / deviation, noise, taken)
    inverse = np.linalg.inv(bread)
    covariance = inverse @ meat @ inverse.T
    longer = _longer(covariance, inverse @ _between_blocks(gradients, grams, information))
    return Spread(
        covariance * np.outer(longer * scale, longer * scale), scale[:, None] * (inverse @ by_scale)
    )


def _level(residual: np.ndarray, weight: np.ndarray, usual: np.ndarray) -> np.ndarray:
    """Root mean square of one run's residual (t, n) by joint; the usual where the joint sticks throughout."""
    counts = weight.sum(axis=0)
    square = np.sum(weight * residual**2, axis=0) / np.maximum(counts, 1.0)
    return np.where(counts > 0, np.maximum(np.sqrt(square), 1e-6 * usual), usual)


def _inverse_root(matrix: np.ndarray) -> np.ndarray:
    """R with R R^T the inverse of a positive definite matrix (k, k), rounding guarded."""
    size, vectors = np.linalg.eigh(matrix)
    return vectors / np.sqrt(np.maximum(size, np.finfo(float).eps * size[-1]))


def _taken(hat: np.ndarray, lags: int) -> np.ndarray:
    """Share of the noise's power that fitting took out of the residual, by frequency, shape (count, n).

    Row t of `hat` (r, n, k) times itself is the leverage of sample t. Unknowns follow the noise at the
    frequencies of their own columns, which are slow; there the residual is shorter than the noise.
    """
    count = 2 * len(hat)
    power = np.sum(np.abs(np.fft.rfft(hat, count, axis=0)) ** 2, axis=2)
    leverage = np.fft.irfft(power, count, axis=0)[: lags + 1] / len(hat)
    leverage = np.pad(leverage, ((0, lags + 1 - len(leverage)), (0, 0)))
    density = spectrum(leverage[:, :, None] * np.eye(hat.shape[1]), count)
    return np.clip(np.diagonal(density, axis1=1, axis2=2).real, 0.0, 0.9)


def sandwich_with_gains(
    equations: Equations, values: np.ndarray, gain: np.ndarray, wide: np.ndarray | None = None
) -> np.ndarray:
    """Covariance of (values, gains), shape (b + n, b + n), where currents are what is predicted.

    Before the data gains have deviations `wide`, shape (n,); infinite ones by default.
    """
    torque = equations.regressor @ values + equations.known
    by_gain = -np.eye(len(gain)) * (torque / gain**2)[:, :, None]
    jacobian = np.concatenate([equations.regressor / gain[None, :, None], by_gain], axis=2)
    before = np.concatenate([np.zeros(len(values)), np.zeros(len(gain)) if wide is None else wide**-2.0])
    return sandwich(jacobian, equations.current - torque / gain, equations, before=before).covariance


BLOCK = 1.0
"""Length of a block [s]: longer than noise and misfit are remembered for the most part, and so short that
runs of some ten seconds have enough of them to scatter."""
MOST_TAKEN = 0.9
"""Share of a block's scatter that fitting took, at most: beyond it what is left says nothing of the noise."""


def blocks(run: slice, rate: float) -> list[slice]:
    """Blocks of time of one run, of about `BLOCK` each."""
    count = max(1, round((run.stop - run.start) / (BLOCK * rate)))
    edges = np.linspace(run.start, run.stop, count + 1).astype(int)
    return [slice(int(a), int(b)) for a, b in zip(edges[:-1], edges[1:], strict=True)]


def _between_blocks(
    gradients: list[np.ndarray], grams: list[np.ndarray], information: np.ndarray
) -> np.ndarray:
    """Gradients of all blocks, shape (k, m), as long as they were before the fit shortened them.

    The fit makes the gradients of all blocks add up to zero. A block that has a share M of the information
    has lost M of its own variance, and is longer by (1 - M)^(-1/2) (the correction CR2 of Bell and McCaffrey
    2002): of m blocks alike, and one unknown, that is the usual m / (m - 1).
    """
    root = _inverse_root(information)
    found = []
    for gradient, gram in zip(gradients, grams, strict=True):
        share, axes = np.linalg.eigh(root.T @ gram @ root)
        more = 1.0 / np.sqrt(1.0 - np.clip(share, 0.0, MOST_TAKEN)) - 1.0
        found.append(gradient + information @ root @ (axes @ (more * (axes.T @ (root.T @ gradient)))))
    return np.array(found).T


FEWEST_BLOCKS = 20
"""Below which their scatter is not asked for: twenty give a deviation to a sixth, fewer mostly chance."""


def _longer(covariance: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """By how much each deviation (k,) is longer by the scatter between blocks, if by more than chance.

    From some tens of blocks a variance is known to a fifth, a covariance of more unknowns than blocks not at
    all: correlations stay those of the noise, which is also the least that is there.

    Args:
        covariance: By the noise, shape (k, k).
        moved: What each block moves each unknown by, shape (k, m).
    """
    variance = np.diag(covariance)
    if moved.shape[1] < FEWEST_BLOCKS:
        return np.ones(len(variance))
    ratio = np.divide(np.sum(moved**2, axis=1), variance, out=np.ones_like(variance), where=variance > 0.0)
    chance = np.sqrt(2.0 / moved.shape[1])  # deviation of a variance that m normal numbers give
    return np.sqrt(np.where(ratio > 1.0 + chance, ratio, 1.0))


def _segments(run: slice) -> Iterator[slice]:
    for start in range(run.start, run.stop, SEGMENT):
        yield slice(start, min(start + SEGMENT, run.stop))


def _coloured_gram(rows: np.ndarray, noise: np.ndarray, taken: np.ndarray) -> np.ndarray:
    """rows^T C rows, shape (k, k), for rows (r, n, k) and C made of the residual's autocovariances.

    The residual's power is raised by what fitting took, `taken` (count, n), to make it the noise's.
    """
    density = spectrum(noise, 2 * len(rows))  # zero padding keeps the ends from meeting
    count, unknowns = len(density), rows.shape[2]
    transform = np.fft.rfft(rows, count, axis=0)
    half = len(transform)
    fold = np.full(half, 2.0)
    fold[0] = 1.0
    if count % 2 == 0:
        fold[-1] = 1.0
    raised = np.sqrt(fold[:, None] / count / (1.0 - taken[:half]))
    coloured = np.matmul(density[:half] * raised[:, :, None] * raised[:, None, :], transform)
    return (transform.reshape(-1, unknowns).conj().T @ coloured.reshape(-1, unknowns)).real
