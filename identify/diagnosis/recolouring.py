"""Recolouring: the evidence of a hypothesis beside noise that is what it leaves.

The colour of noise is taken from a residual. What is missing is in that residual too: a slow effect makes the
noise look slow, and is then whitened away with it. So the colour is found anew beside each hypothesis, and
what counts is how probable all rows are, each hypothesis with its own noise.
"""

from dataclasses import replace

import numpy as np

from .candidate import Thinned
from .hypothesis import Hypothesis, strange
from .solution import Share, Solution, marginal, one_sided
from .whitening import Whitening

AGAIN = 8
"""Times that coefficients and colour are found in turn, at most."""
FIXED = 1e-6
"""Freedom of a coefficient that is at its limit, share of that; a number for the computer."""
SETTLED = 0.1
"""Change of the logarithm of a probability that is not worth another turn."""


def recoloured(solution: Solution, hypothesis: Hypothesis) -> tuple[Hypothesis, Whitening]:
    """The hypothesis with its evidence and coefficients beside noise of its own colour, and that colour."""
    columns, lower = hypothesis.columns, np.array(hypothesis.candidate.lower)
    held = hypothesis.values <= lower
    while not np.all(held & (lower == 0.0)):
        # What is at a limit stays there; at zero it need not be solved for.
        free = ~(held & (lower == 0.0))
        mean = np.where(held, lower, columns.mean)[free]
        std = np.where(held, FIXED * np.abs(lower), hypothesis.std)[free]
        values, evidence, whitening = _solved(solution, columns, free, mean, std)
        below = ~held[free] & (values < lower[free])
        if not np.any(below):
            whole = np.zeros(len(free))
            whole[free] = values
            if strange(columns, whole):
                break
            moving = ~held
            own = evidence + one_sided((lower - columns.mean)[moving], hypothesis.std[moving])
            own += float(np.log(hypothesis.candidate.prior))
            # To average over shapes and sizes costs what it did.
            averaged = own + hypothesis.evidence - hypothesis.own
            return replace(hypothesis, values=whole, evidence=averaged, own=own), whitening
        held[np.flatnonzero(free)[below]] = True
    return replace(hypothesis, evidence=-np.inf, own=-np.inf), solution.whitening


def _solved(
    solution: Solution, columns: Thinned, free: np.ndarray, mean: np.ndarray, std: np.ndarray
) -> tuple[np.ndarray, float, Whitening]:
    """Coefficients of the free columns, logarithm of the Bayes factor, and colour of what is left."""
    known = np.concatenate([solution.known, 1.0 / std**2])
    believed = np.concatenate([solution.rows.mean, np.zeros(len(mean))])
    whitening, evidence, values = solution.whitening, -np.inf, mean
    for _ in range(AGAIN):
        shares = _shares(solution, columns.values[:, :, free], columns.joints, mean, whitening)
        found, probability = marginal(shares, known, believed)
        if probability < evidence + SETTLED:
            break
        best, evidence, values = whitening, probability, found[len(solution.known) :] + mean
        for place, joint in enumerate(columns.joints):
            left = solution.rows.difference[:, joint] - columns.values[:, place][:, free] @ values
            left = left - solution.rows.columns[:, joint] @ found[: len(solution.known)]
            whitening = whitening.recoloured(int(joint), left)
    return values, evidence - solution.probability, best


def _shares(
    solution: Solution, columns: np.ndarray, joints: np.ndarray, mean: np.ndarray, whitening: Whitening
) -> list[Share]:
    """What each joint's rows say of all unknowns and of further columns (r, k, p) about their means (p,)."""
    rows, count, more = solution.rows, len(solution.rows.std), columns.shape[2]
    shares = [
        Share(np.pad(own.gram, (0, more)), np.pad(own.right, (0, more)), own.square, own.logarithm)
        for own in solution.shares
    ]
    for place, joint in enumerate(int(j) for j in joints):
        target = rows.difference[:, joint] - columns[:, place] @ mean
        whole = np.column_stack([rows.columns[:, joint, rows.acting[joint]], columns[:, place], target])
        white = whitening.apply(joint, whole)
        acting, size = np.append(rows.acting[joint], count + np.arange(more)), whitening.logarithm(joint)
        shares[joint] = Share.of(white[:, :-1], white[:, -1], size, acting, count + more)
    return shares
