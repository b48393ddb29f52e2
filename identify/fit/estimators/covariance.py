r"""Covariance of an estimate under coloured noise.

With weights :math:`1/\sigma_j^2` and rows :math:`J_j`, :math:`H = \sum_j J_j^T J_j / \sigma_j^2`, the
estimate's covariance is :math:`H^{-1} S H^{-1}`, where S is the covariance of the gradient,
:math:`S = \sum_{jk} J_j^T C_{jk} J_k / (\sigma_j \sigma_k)^2`, and C the noise's covariance over time
and joints: encoder noise of one joint is acceleration noise in the torque of several. C comes from the
residual's autocovariances and is applied in the frequency domain. White noise would give
:math:`H^{-1}`, which at the residuals of real arms claims intervals several times too short.

That holds for a residual that is alike throughout a run. What a model lacks is not: it comes where a joint
is slow, or far out. `block_scatter` therefore compares with the gradient's scatter between blocks of time.

Nominal drive gains are wrong by their tolerance. A relative error :math:`\delta_j` adds the measured torque
of joint j times :math:`\delta_j` to what is fitted, so that it moves the estimate by
:math:`\partial\beta/\partial\delta_j`, the solution for that torque alone: see `with_nominal_gains`.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...preparation.noise import autocovariance, spectrum
from ..equations import Equations
from .block_scatter import between_blocks, blocks, inverse_root, longer_by

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
    every = [rows for run in equations.runs for rows in blocks(run, equations.rate)]
    parts = [
        _part(
            weighted_rows(left, rows),
            weighted_rows(jacobian, rows),
            residual[rows] / deviation[:, 0],
            torque[rows] / deviation[:, 0],
        )
        for rows in every
    ]
    sums, meat = _Part(*(np.sum(one, axis=0) for one in zip(*parts, strict=True))), np.diag(held)
    bread, information = sums.bread + meat, sums.information + meat
    root = inverse_root(information)
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
    moved = between_blocks([p.gradient for p in parts], [p.information for p in parts], information)
    longer = scale * longer_by(covariance, inverse @ moved)
    return Spread(covariance * np.outer(longer, longer), scale[:, None] * (inverse @ sums.by_scale))


class _Part(NamedTuple):
    """What one block of time adds to sums over all rows.

    Attributes:
        bread: Instruments times rows, shape (k, k).
        information: Rows times rows, shape (k, k).
        gradient: Instruments times residual, shape (k,).
        by_scale: Instruments times each joint's torque, shape (k, n).
    """

    bread: np.ndarray
    information: np.ndarray
    gradient: np.ndarray
    by_scale: np.ndarray


def _part(left: np.ndarray, right: np.ndarray, residual: np.ndarray, torque: np.ndarray) -> _Part:
    """Of instruments (r, n, k), rows (r, n, k), residual and torque (r, n), all over the noise."""
    unknowns = left.shape[2]
    moved, rows = left.reshape(-1, unknowns), right.reshape(-1, unknowns)
    by_scale = np.einsum("rnk,rn->kn", left, torque)
    return _Part(moved.T @ rows, rows.T @ rows, moved.T @ residual.ravel(), by_scale)


def _level(residual: np.ndarray, weight: np.ndarray, usual: np.ndarray) -> np.ndarray:
    """Root mean square of one run's residual (t, n) by joint; the usual where the joint sticks throughout."""
    counts = weight.sum(axis=0)
    square = np.sum(weight * residual**2, axis=0) / np.maximum(counts, 1.0)
    return np.where(counts > 0, np.maximum(np.sqrt(square), 1e-6 * usual), usual)


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
