"""Drive gains as an open item: whether the runs by themselves confirm the stated gains.

If masses are not stated, a gain that is wrong by a fifth makes all masses wrong by a fifth, and no motion of
the arm alone shows it. The tolerance of a gain is then an untested assumption, and so is every mass. A gain
is tested once the runs alone, without its tolerance, determine it at least as well as the tolerance does.
"""

import numpy as np

from ...fit.settled_gains import OPEN
from ...positive_definite import solve
from ..blocks.prediction import LINEAR, factored
from ..runs.rows import GAIN, UNKNOWN_GAIN
from ..words.naming import joined, joint_words, lower
from .belief import Belief

GAINS = "drive gains"
"""Name of the item."""
SAME = 1e-6
"""Relative residual below which two columns count as the same torque [-]: rounding."""


def gain_entropy(belief: Belief, seen: np.ndarray | None = None) -> float:
    """Entropy of the gains after the runs so far, and after a run with products `seen` (c, c) [nat].

    It is half the sum of log(1 + s^2), where s is the standard deviation of a gain over the required one.
    """
    share = gain_deviations(belief, seen) / _required(belief)
    return 0.5 * float(np.sum(np.log1p(share**2)))


def untested(belief: Belief, seen: np.ndarray | None = None) -> list[int]:
    """Joints whose gains the runs, and a further run with products `seen` (c, c), do not confirm."""
    exceeded = gain_deviations(belief, seen) > _required(belief)
    return [joint for joint, is_open in zip(_joints(belief), exceeded, strict=True) if is_open]


def gain_words(belief: Belief) -> str:
    """Text that says which gains no run has tested, what follows, and what would test them."""
    robot = belief.search.problem.model.robot
    joints = [joint_words(joint, robot.joints) for joint in untested(belief)]
    return (
        f"Drive gains of {lower(joined(joints, 'and'))} are taken as stated: no run so far or on offer tests "
        "them, and their errors carry over to inertias and friction. What would test them: a run with a body "
        "of known mass on the flange, off the axis of the joint."
    )


def gain_deviations(belief: Belief, seen: np.ndarray | None = None) -> np.ndarray:
    """Relative standard deviation of each gain from the runs alone, shape (g,) [-]; empty for torque.

    Unknowns whose torque equals that of a gain are left out, because they stand for the gain.
    """
    places = _places(belief)
    if not len(places):
        return np.zeros(0)
    gram = belief.gram[: belief.unknowns, : belief.unknowns]
    size = np.diag(gram)
    mixed = gram[places] ** 2 > (1.0 - SAME) * np.outer(size[places], size)
    same = np.setdiff1d(np.flatnonzero(np.any(mixed & (size > 0.0), axis=0)), places)
    held = np.setdiff1d(np.arange(belief.unknowns), same)
    matrix = gram[np.ix_(held, held)] + (0.0 if seen is None else seen[np.ix_(held, held)])
    precision = belief.precision.copy()
    precision[places] = UNKNOWN_GAIN**-2.0
    selection = np.eye(len(held))[:, np.searchsorted(held, places)]
    covariance = selection.T @ solve(factored(matrix + np.diag(precision[held])), selection)
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def _required(belief: Belief) -> np.ndarray:
    """Relative standard deviation to which runs must determine each gain, shape (g,) [-].

    It is the stated tolerance, but no finer than the linearity of sensors and no coarser than `OPEN`.
    """
    return np.clip(belief.search.prediction.rows.std[_places(belief)], LINEAR, OPEN)


def _places(belief: Belief) -> np.ndarray:
    """Indices of the gains among the unknowns, shape (g,)."""
    names = belief.search.prediction.rows.names
    return np.array([k for k, name in enumerate(names) if name in _named(belief)], dtype=int)


def _joints(belief: Belief) -> list[int]:
    names = belief.search.prediction.rows.names
    return [_named(belief)[names[place]] for place in _places(belief)]


def _named(belief: Belief) -> dict[str, int]:
    return {f"{GAIN}{joint + 1}": joint for joint in range(belief.search.problem.model.robot.dof)}
