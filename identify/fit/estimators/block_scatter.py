"""Scatter between blocks of time: unlike noise, model errors vary over a run."""

from collections.abc import Sequence

import numpy as np

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
