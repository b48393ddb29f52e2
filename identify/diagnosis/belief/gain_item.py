"""Drive gains as an item: whether the runs show by themselves what is stated of them.

Where masses are not stated, a gain that is a fifth off makes them all a fifth too large, and no motion of the
arm alone shows it: the tolerance of a gain is then a claim that nothing has tested, and so is every mass. It
is tested once the runs, without that claim, leave no more of the gain open than it does.
"""

import numpy as np

from ...fit.settled_gains import OPEN
from ...positive_definite import solve
from ..blocks.prediction import LINEAR, factored
from ..runs.rows import GAIN, UNKNOWN_GAIN
from ..words.naming import joined, joint_words, lower
from .belief import Belief

GAINS = "drive gains"
"""What the item is called."""
SAME = 1e-6
"""Share of a column's square that another leaves from which on both are the same torque: rounding."""


def gain_entropy(belief: Belief, seen: np.ndarray | None = None) -> float:
    """Of what the runs leave open of the gains [nat]; behind a run with products `seen` (c, c).

    Half the sum of log(1 + s^2), s the deviation of each over what is to be shown of it.
    """
    share = gain_deviations(belief, seen) / _wanted(belief)
    return 0.5 * float(np.sum(np.log1p(share**2)))


def untested(belief: Belief, seen: np.ndarray | None = None) -> list[int]:
    """Joints of whose gains the runs, and products `seen` (c, c) of another, show less than is stated."""
    open_ones = gain_deviations(belief, seen) > _wanted(belief)
    return [joint for joint, one in zip(_joints(belief), open_ones, strict=True) if one]


def gain_words(belief: Belief) -> str:
    """Which gains no run has tested, what follows, and what would test them."""
    robot = belief.search.problem.model.robot
    joints = [joint_words(joint, robot.joints) for joint in untested(belief)]
    return (
        f"Drive gains of {lower(joined(joints, 'and'))} are as stated: no run so far or on offer tests that, "
        "and inertias and friction are wrong by as much as they are. What would: a run with a body of known "
        "mass on the flange, off the axis of the joint."
    )


def gain_deviations(belief: Belief, seen: np.ndarray | None = None) -> np.ndarray:
    """Deviation of each gain by the runs alone, over its value, shape (g,) [-]; none for torque.

    What was found to be the same torque is the gain.
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
    own = np.searchsorted(held, places)
    rows = np.eye(len(held))[:, own]
    covariance = rows.T @ solve(factored(matrix + np.diag(precision[held])), rows)
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def _wanted(belief: Belief) -> np.ndarray:
    """Deviation to which each gain is to be shown, shape (g,): what is stated, where that is not open.

    Nor finer than sensors are linear.
    """
    return np.clip(belief.search.prediction.rows.std[_places(belief)], LINEAR, OPEN)


def _places(belief: Belief) -> np.ndarray:
    """Of the gains among the unknowns, (g,)."""
    names = belief.search.prediction.rows.names
    return np.array([k for k, name in enumerate(names) if name in _named(belief)], dtype=int)


def _joints(belief: Belief) -> list[int]:
    names = belief.search.prediction.rows.names
    return [_named(belief)[names[place]] for place in _places(belief)]


def _named(belief: Belief) -> dict[str, int]:
    return {f"{GAIN}{joint + 1}": joint for joint in range(belief.search.problem.model.robot.dof)}
