"""Scatter between blocks of time: what a model lacks is not alike throughout a run, as noise is."""

from collections.abc import Sequence

import numpy as np

BLOCK = 1.0
"""Length of a block [s]: longer than noise and misfit are remembered for the most part, and so short that
runs of some twenty seconds have enough of them to scatter."""
SHORTEST = 10
"""Rows of a block, at least: slow rows make longer blocks."""
FEWEST_BLOCKS = 20
"""Blocks below which their scatter is not asked for: twenty give a deviation to a sixth, fewer chance."""
MOST_TAKEN = 0.9
"""Share of a block's scatter that fitting took, at most: beyond it what is left says nothing of the noise."""


def blocks(run: slice, rate: float) -> list[slice]:
    """Blocks of time of one run, of about `BLOCK` each."""
    count = max(1, round((run.stop - run.start) / max(BLOCK * rate, SHORTEST)))
    edges = np.linspace(run.start, run.stop, count + 1).astype(int)
    return [slice(int(a), int(b)) for a, b in zip(edges[:-1], edges[1:], strict=True)]


def between_blocks(
    gradients: Sequence[np.ndarray], grams: Sequence[np.ndarray], information: np.ndarray
) -> np.ndarray:
    """Gradients of all blocks, shape (k, m), as long as they were before the fit shortened them.

    The fit makes the gradients of all blocks add up to zero. A block that has a share M of the information
    has lost M of its own variance, and is longer by (1 - M)^(-1/2) (the correction CR2 of Bell and McCaffrey
    2002): of m blocks alike, and one unknown, that is the usual m / (m - 1).

    Args:
        gradients: Of each block, (k,).
        grams: Information of each block, (k, k).
        information: Of all, and of what is known before the data, shape (k, k).
    """
    root = inverse_root(information)
    found = []
    for gradient, gram in zip(gradients, grams, strict=True):
        share, axes = np.linalg.eigh(root.T @ gram @ root)
        more = 1.0 / np.sqrt(1.0 - np.clip(share, 0.0, MOST_TAKEN)) - 1.0
        found.append(gradient + information @ root @ (axes @ (more * (axes.T @ (root.T @ gradient)))))
    return np.array(found).T


def longer_by(covariance: np.ndarray, moved: np.ndarray) -> np.ndarray:
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


def inverse_root(matrix: np.ndarray) -> np.ndarray:
    """R with R R^T the inverse of a positive definite matrix (k, k), rounding guarded."""
    size, vectors = np.linalg.eigh(matrix)
    return vectors / np.sqrt(np.maximum(size, np.finfo(float).eps * size[-1]))
