"""Agreement: what rows tell of a finding, and whether all joints and all runs say the same of its size.

An effect has one size, whichever motor tells it and in whichever run. What fits here and not there is
something else that happens to look alike: an arm that a disturbance moves, say, shows a motion that goes with
its disturbance, and a link that swings on its gear seems to swing with it.
"""

from typing import NamedTuple

import numpy as np
from scipy import stats

from .found import Found
from .held_out import columns_of
from .search import Searched
from .solution import CERTAIN, Solution

CHANCE = 1e-3
"""Probability with which noise alone lets joints and runs disagree as much as is held against a finding."""
LEAST = 1e-3
"""Share of all information on a size from which on a joint in a run is asked for it [-]."""


def agreed(found: Searched, one: Found) -> float:
    """Logarithm of a finding's odds, its evidence being worth what joints and runs agree upon.

    Where they disagree by more than chance, rows are less sure than noise lets them seem, by as much as it
    takes that they do not; as for constants of nature that were measured twice (R. T. Birge, The calculation
    of errors by the method of least squares, 1932).
    """
    if np.all(one.hypothesis.columns.whole):
        return one.odds  # it has no size
    said, known, _ = sizes(found, one)
    whole = float(np.sum(known))
    if len(known) < 2 or whole <= 0.0:
        return one.odds
    mean = np.sum(known * said) / whole
    spread, freedom = float(np.sum(known * (said - mean) ** 2)), len(known) - 1
    if stats.chi2.sf(spread, freedom) > CHANCE:
        return one.odds
    return one.odds - max(one.hypothesis.own, 0.0) * (1.0 - freedom / spread)


def told(found: Searched, one: Found) -> float:
    """What rows gain by a finding, in twice a logarithm, where everything else may do what it can instead.

    The rest of its evidence is that other unknowns need not be far from what is believed of them: whoever has
    fitted them so far foretells other runs as well without it.
    """
    without, solution = _without(found, one), found.solution
    gained = sum(float(a @ a - b @ b) for a, b in zip(without.left, solution.left, strict=True))
    return float(np.clip(gained, 0.0, 2.0 * max(one.hypothesis.evidence, 0.0)))


def _without(found: Searched, one: Found) -> Solution:
    """All unknowns but those of a finding, solved anew."""
    own = columns_of(found, _place(found, one))
    return found.solution.believing(own, np.full(len(own), CERTAIN))


def _place(found: Searched, one: Found) -> int:
    return next(k for k, other in enumerate(found.found) if other is one)


def loudest(found: Searched, one: Found) -> tuple[int, float]:
    """The joint that gains most by a finding, and what all others gain together, in twice a logarithm."""
    said, known, joints = sizes(found, one)
    gained = np.bincount(joints, known * (2.0 * said - 1.0), minlength=found.solution.joints)
    most = int(np.argmax(gained))
    return most, float(np.sum(gained) - gained[most])


class Sizes(NamedTuple):
    """Size of a finding as each joint in each run has it, over that of all.

    Attributes:
        said: Shape (g,) [-].
        known: Inverse variances, shape (g,).
        joints: Which joint has it, from 0, shape (g,).
    """

    said: np.ndarray
    known: np.ndarray
    joints: np.ndarray


def sizes(found: Searched, one: Found) -> Sizes:
    """What each joint in each run says, everything else being solved for.

    What other unknowns could do as well tells nothing.
    """
    own, columns = columns_of(found, _place(found, one)), one.hypothesis.columns
    torque = np.zeros_like(found.rows.difference)
    torque[:, columns.joints] = columns.values @ found.solution.values[own]
    without = _without(found, one)
    said, known, joints = [], [], []
    for joint, alone in enumerate(without.alone(torque)):
        counted = np.flatnonzero(without.whitening.valid[:, joint])
        for run in found.rows.runs:
            here = slice(*np.searchsorted(counted, (run.start, run.stop)))
            known.append(float(alone[here] @ alone[here]))
            said.append(float(alone[here] @ without.left[joint][here]))
            joints.append(joint)
    weight = np.array(known)
    asked = weight > LEAST * np.sum(weight)
    return Sizes(np.array(said)[asked] / weight[asked], weight[asked], np.array(joints)[asked])
