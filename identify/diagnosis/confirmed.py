"""Confirmed: which findings stand once runs held out, the noise and what is left have been looked at."""

from collections.abc import Sequence

import numpy as np

from ..model import Model
from .agreement import agreed, loudest, told
from .candidate import Candidate, Thinned
from .driven import Driven
from .formulas import FORMULA
from .found import CERTAIN_ODDS, Found
from .held_out import HeldOut, columns_of
from .hypothesis import strange
from .remainder import Left, excess, greatest, least_evidence, rms
from .search import Searched

Features = Sequence[tuple[Candidate, Thinned]]
ONCE = ("contact_event",)
"""What happens in one run and says nothing of another."""
SURE = 16.0
"""Gain on runs held out, in twice a logarithm, that is two of its standard deviations above none."""
NEGLIGIBLE = 0.1
"""Torque over the noise floor below which an effect, be it real, changes a residual by half a per cent."""
MOSTLY = 0.6
"""Share of the evidence and of the power on a joint that its findings must account for to be named [-]."""

OWN = {
    "position_dependent_friction": "position and direction",
    "load_dependent_friction": "load",
    "stribeck_friction": "velocity",
    "nonlinear_viscous_friction": "velocity",
    "temperature_dependent_friction": "time",
    "joint_spring": "position",
    "spring_balancer": "position",
}
"""What an effect goes with by its physics: more of that left is its formula's error, and nothing else."""


def confirmed(
    model: Model, found: Searched, held_out: Sequence[Driven], features: Features, noise: np.ndarray
) -> Searched:
    """Without findings that runs held out speak against, that are negligible, or mostly something else.

    Args:
        model: As believed.
        found: What a search has come to.
        held_out: Runs that were not fitted.
        features: Of the runs that were.
        noise: Noise floor of each joint's torque, shape (n,) [N m].
    """
    share = sum(run.rows for run in held_out) / sum(run.rows for run in found.runs)
    pairs = list(zip(found.found, gained(found, HeldOut.of(model, found, held_out)), strict=True))
    good = [
        k
        for k, (one, gain) in enumerate(pairs)
        if _stands(one, gain, share * told(found, one))
        and agreed(found, one) > CERTAIN_ODDS
        and _felt(found, one)
        and _matters(found, one, noise)
        and _possible(found, k)
    ]
    found = found if len(good) == len(pairs) else found.keeping(good)
    if not found.found:
        return found
    left = greatest(found.solution, features, noise)
    named = [k for k, one in enumerate(found.found) if not _mostly_else(found, one, left, noise)]
    return found if len(named) == len(found.found) else found.keeping(named)


def unaccounted(found: Searched, left: Sequence[Left], held_out: HeldOut | None) -> list[Left]:
    """What is left on joints, and is not only the error of the formulas of what was found there.

    Runs held out have to bear it out, as they have to for a finding.
    """
    least = least_evidence(found.rows.difference.shape[1])
    every = [one for one in left if one.evidence > max(least, FORMULA**2 * _named(found, one.joint))]
    if held_out is None:
        return every
    return [one for one in every if one.evidence + 0.5 * held_out.further(found, one.hypothesis) > least]


def gained(found: Searched, held_out: HeldOut | None) -> list[float]:
    """What each finding gains on runs held out, see `HeldOut.gain`; NaN without any."""
    if held_out is None:
        return [float("nan")] * len(found.found)
    return [held_out.gain(found, place) for place in range(len(found.found))]


def _stands(one: Found, gain: float, expected: float) -> bool:
    """Whether it is still credible with what runs held out say, that are expected to gain so much by it."""
    if not np.isfinite(gain) or gain > 0 or one.hypothesis.candidate.effect in ONCE:
        return True
    # Give or take twice the root of it: chance alone seldom takes all of much.
    return bool(expected < SURE and one.odds + 0.5 * gain > CERTAIN_ODDS)


def _felt(found: Searched, one: Found) -> bool:
    """Whether a touch of the arm is one.

    What one joint alone feels once is told from a touch only where nothing else was found on that joint,
    whose formula may fail there.
    """
    if one.hypothesis.candidate.effect not in ONCE:
        return True
    joint, beside = loudest(found, one)
    others = [other.hypothesis for other in found.found if other is not one]
    return beside > SURE or not any(joint in other.columns.joints for other in others)


def _possible(found: Searched, place: int) -> bool:
    """Whether its coefficients are what physics allows, beside all others."""
    hypothesis, own = found.found[place].hypothesis, columns_of(found, place)
    values, std = found.solution.values[own], np.sqrt(np.diag(found.solution.covariance)[own])
    lower = np.array(hypothesis.candidate.lower)
    if np.any(values + 2.0 * std < lower) or strange(hypothesis.columns, values):
        return False
    return bool(np.any(lower < 0.0) or np.any(values > lower))


def _matters(found: Searched, one: Found, noise: np.ndarray) -> bool:
    """Whether its torque is worth a name in any run on any joint."""
    columns = one.hypothesis.columns
    weight = found.rows.weight[:, columns.joints]
    torque = _torque(found, one)
    torques = [rms(torque[rows], weight[rows]) for rows in found.rows.runs]
    return bool(np.any(np.max(torques, axis=0) > NEGLIGIBLE * noise[columns.joints]))


def _torque(found: Searched, one: Found) -> np.ndarray:
    """Torque of a finding beside all others, shape (r, k) of the joints of its columns [N m]."""
    place = next(k for k, other in enumerate(found.found) if other is one)
    return one.hypothesis.columns.values @ found.solution.values[columns_of(found, place)]


def _mostly_else(found: Searched, one: Found, left: Sequence[Left], noise: np.ndarray) -> bool:
    """Whether what is left on the joint that it moves most is no less than what is explained there.

    Both by evidence and by torque: what is slow is much torque and little evidence. What explains less than
    is left may be a trace of that.
    """
    columns, torque = one.hypothesis.columns, _torque(found, one)
    strength = rms(torque, found.rows.weight[:, columns.joints])
    joint = int(columns.joints[np.argmax(strength / found.solution.whitening.scale[columns.joints])])
    least = least_evidence(found.rows.difference.shape[1])
    rest = [other for other in left if other.joint == joint and other.evidence > least]
    evidence = max((other.evidence for other in rest), default=0.0)
    if one.hypothesis.evidence < evidence:
        return True
    if any(other.depends_on == OWN.get(one.hypothesis.candidate.effect) for other in rest):
        return False
    power = excess(found.solution, joint, float(noise[joint]))
    power = max([power, *(float(np.mean(other.hypothesis.torque**2)) for other in rest)])
    named, named_power = _named(found, joint), float(np.mean(_named_torque(found, joint) ** 2))
    return bool(named < MOSTLY * (named + evidence) or named_power < MOSTLY * (named_power + power))


def _named_torque(found: Searched, joint: int) -> np.ndarray:
    """Torque of all findings on a joint, shape (r,) [N m]."""
    first = columns_of(found, 0)[0]
    return found.rows.columns[:, joint, first:] @ found.solution.values[first:]


def _named(found: Searched, joint: int) -> float:
    """Evidence of all findings that give torque to a joint."""
    evidence = [one.hypothesis.evidence for one in found.found if joint in one.hypothesis.columns.joints]
    return float(np.sum(np.maximum(evidence, 0.0)))
