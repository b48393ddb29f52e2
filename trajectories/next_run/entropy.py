"""Entropy of a question with a few answers, now and as a run is expected to leave it [nat]."""

import numpy as np
from scipy.special import entr

DRAWS = 256
"""Outcomes of a run over which entropies are averaged: to a sixteenth of how much they scatter."""


def entropy(probability: np.ndarray) -> float:
    """Of answers with these probabilities, shape (m,) [nat]."""
    return float(entr(probability).sum())


def expected_entropy(probability: np.ndarray, separation: np.ndarray) -> float:
    """Of the same answers after a run, averaged over what it may show [nat].

    Where answer i is true and j its rival, the run multiplies the odds of i against j by a factor whose
    logarithm is normal, of mean T/2 and variance T, with T their separation.

    Args:
        probability: Before the run, shape (m,).
        separation: Row is true, column its rival, shape (m, m).
    """
    normal = np.random.default_rng(0).normal(size=(DRAWS // 2, len(probability)))
    normal = np.concatenate([normal, -normal])
    total = 0.0
    for true in np.flatnonzero(probability):
        gained = separation[true] / 2.0 + np.sqrt(separation[true]) * normal
        gained[:, true] = 0.0
        with np.errstate(divide="ignore"):
            weight = np.log(probability) - np.clip(gained, -700.0, 700.0)
        after = np.exp(weight - np.max(weight, axis=1, keepdims=True))
        after /= after.sum(axis=1, keepdims=True)
        total += float(probability[true]) * float(entr(after).sum(axis=1).mean())
    return min(total, entropy(probability))  # of every run, but not of every draw
