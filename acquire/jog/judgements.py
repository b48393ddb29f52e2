"""Judgements: what a jog shows of a joint, each with a value, what was expected, and what that means."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from exidyn.identification.model import Model

from .effort import Effort, effort_of, torque_at_rest
from .there_and_back import Course, Way

NO_PART = 0.1
"""Share of the way up to which a joint counts as standing, and by which the one that moves may miss it [-].
What is set wrongly is wrong by a factor or a sign; play, springs and coarse encoders stay below: two counts
of 4096 a turn are 0.18 degrees."""
FEWEST = 0.25
"""Share of the way that must have been commanded before a stop for anything to be judged [-]."""
DEVIATIONS = 3.0
"""Standard deviations from which on a value counts as seen: chance alone gives that once in 400."""
FACTOR = 4.0 / 3.0
"""Factor between measured and nominal torque that is in order [-]: masses and gains of data sheets are
better than that, and a gain that is of the peak instead of the r.m.s. current (1.41), or half, is not."""
FARTHEST = np.radians(30)
"""Wrong zero up to which gravity is followed [rad]; one that shows only beyond is reported as unknown."""
STEP = np.radians(1)
OF_WAY = "of the way"
"""Unit of what is a share of the commanded way."""
ROUNDING = 1e-9
"""Torque that is none [N m]: what is left where terms cancel."""
NOT_GONE = "it did not go as commanded, so that its torque is of another motion"


class Verdict(StrEnum):
    """Verdict about one property."""

    RIGHT = "right"
    WRONG = "WRONG"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class Judgement:
    """One thing that was looked at.

    Attributes:
        name: What it is.
        value: Measured; NaN where nothing was.
        low: Smallest value that is in order.
        high: Largest.
        unit: Unit of these.
        verdict: The verdict.
        text: Why, and what to look at; empty where the numbers suffice.
    """

    name: str
    value: float
    low: float
    high: float
    unit: str
    verdict: Verdict
    text: str = ""


def judge(course: Course, way: Way, model: Model, payload: str = "") -> list[Judgement]:
    """All results of a jog, by the nominal model with the body that it carries, whose name may be empty."""
    joints = model.robot.joints
    commanded = course.commanded[:, way.joint] if len(course.commanded) else np.zeros(1)
    if np.ptp(commanded) < FEWEST * abs(way.distance):
        why = f"stopped before a quarter of the way was commanded ({joints[way.joint]})"
        return [Judgement("way", np.nan, 1 - NO_PART, 1 + NO_PART, OF_WAY, Verdict.UNKNOWN, why)]
    shares = _shares(course, way.joint)
    found = [_way(shares, way.joint), _others(shares, way.joint, joints)]
    effort = effort_of(course, way, model) if found[0].verdict is Verdict.RIGHT else NOT_GONE
    if isinstance(effort, str):
        names = ("friction with the motion", "gravity torque", "encoder zero")
        return found + [_unknown(name, effort) for name in names]
    friction = _friction(effort)
    gravity, measured = _gravity(effort, friction, way, model, payload)
    return [*found, friction, gravity, _zero(measured, gravity, effort, way, model, payload)]


def _shares(course: Course, joint: int) -> np.ndarray:
    """Share of the commanded way that each joint went, by least squares over the motion, shape (n,) [-]."""
    commanded = course.commanded[:, joint]
    shares = np.full(course.position.shape[1], np.nan)
    for other in range(len(shares)):
        known = np.isfinite(course.position[:, other])
        away = commanded[known] - commanded[known].mean() if known.any() else commanded[:0]
        if away.size and away @ away > 0.0:
            shares[other] = away @ course.position[known, other] / (away @ away)
    return shares


def _way(shares: np.ndarray, joint: int) -> Judgement:
    share = float(shares[joint])
    low, high = 1.0 - NO_PART, 1.0 + NO_PART
    if low <= share <= high:
        return Judgement("way", share, low, high, OF_WAY, Verdict.RIGHT)
    if abs(share) <= NO_PART:
        text = "it did not move: brake, drive, or the encoder of another joint"
    elif share < 0.0:
        text = "it moved against the command: the encoder's sign and the command's differ"
    else:
        text = "its scale: counts, gear ratio or resolution in the controller's settings"
    return Judgement("way", share, low, high, OF_WAY, Verdict.WRONG, text)


def _others(shares: np.ndarray, joint: int, joints: tuple[str, ...]) -> Judgement:
    name = "largest way of another joint"
    others = np.where(np.arange(len(shares)) == joint, 0.0, np.abs(np.nan_to_num(shares)))
    worst = int(np.argmax(others))
    value = float(others[worst])
    if value <= NO_PART:
        return Judgement(name, value, 0.0, NO_PART, OF_WAY, Verdict.RIGHT)
    text = (
        f"{joints[worst]} moved with it: the order of the joints in the settings, or a coupling that the "
        "controller does not take out"
    )
    return Judgement(name, value, 0.0, NO_PART, OF_WAY, Verdict.WRONG, text)


def _unknown(name: str, why: str, value: float = np.nan, unit: str = "") -> Judgement:
    return Judgement(name, value, np.nan, np.nan, unit, Verdict.UNKNOWN, why)


def _friction(effort: Effort) -> Judgement:
    """A drive pushes with the motion, whatever gravity does: half the difference between there and back."""
    name, least = "friction with the motion", DEVIATIONS * effort.friction_std
    value = effort.friction
    if abs(value) <= least:
        why = "friction is too small to be seen"
        return Judgement(name, value, least, np.inf, effort.unit, Verdict.UNKNOWN, why)
    if value > 0.0:
        return Judgement(name, value, least, np.inf, effort.unit, Verdict.RIGHT)
    text = f"the drive seems to push against the motion: the sign of {effort.source}"
    return Judgement(name, value, least, np.inf, effort.unit, Verdict.WRONG, text)


def _gravity(
    effort: Effort, friction: Judgement, way: Way, model: Model, payload: str
) -> tuple[Judgement, tuple[float, float]]:
    """The mean of there and back, in which friction cancels, against the nominal torque at rest.

    And the interval in which that torque is [N m]: give or take the friction, which may differ each way.
    """
    name, unit = "gravity torque", effort.unit
    nominal = float(torque_at_rest(model, effort.middle[None], payload)[0, way.joint])
    nominal = nominal if abs(nominal) > ROUNDING else 0.0
    low, high = sorted((nominal / FACTOR, nominal * FACTOR))
    uncertainty = abs(effort.friction) + DEVIATIONS * effort.gravity_std
    value = effort.gravity
    known = (value - uncertainty, value + uncertainty)
    inside = low <= value <= high
    if known[1] < low or known[0] > high:
        text = _why_gravity(effort, friction, nominal)
        return Judgement(name, value, low, high, unit, Verdict.WRONG, text), known
    if abs(nominal) >= uncertainty and inside:
        return Judgement(name, value, low, high, unit, Verdict.RIGHT), known
    why = (
        f"friction may shift it by {uncertainty:.3g} {unit}, and {abs(nominal):.3g} {unit} are nominal: "
        "jog it where gravity is larger"
    )
    return Judgement(name, value, low, high, unit, Verdict.UNKNOWN, why), known


def _why_gravity(effort: Effort, friction: Judgement, nominal: float) -> str:
    where = "the load on the flange (--mass), masses in the robot file, the zero or the order of the joints"
    if effort.gravity * nominal < 0.0:
        if friction.verdict is Verdict.WRONG:
            return f"as friction: the sign of {effort.source}"
        return f"the other way than nominal: the joint's sign or zero, or {where}"
    if abs(nominal) < effort.friction_std:
        return f"none is nominal here: {where}"
    return f"{effort.gravity / nominal:.2f} of the nominal one: {effort.source}, or {where}"


def _zero(
    measured: tuple[float, float], gravity: Judgement, effort: Effort, way: Way, model: Model, payload: str
) -> Judgement:
    """How wrong the zero could be without gravity showing it, if gain and masses are nominal."""
    name = "encoder zero"
    if gravity.verdict is not Verdict.RIGHT or not model.robot.revolute[way.joint]:
        return _unknown(name, "cannot be judged from this motion")
    low, high = (_hidden(measured, sign, effort, way, model, payload) for sign in (-1.0, 1.0))
    if not np.isfinite(low) and not np.isfinite(high):
        far = f"{np.degrees(FARTHEST):g} degrees from the joint's reading"
        return _unknown(name, f"cannot be judged from this motion: {far} gravity would be as measured too")
    shows = [f"{np.degrees(end):+.0f}" for end in (-low, high) if np.isfinite(end)]
    text = (
        f"{' or '.join(shows)} degrees from the joint's reading, gravity would not be as measured, if "
        "gain and masses are right"
    )
    if len(shows) < 2:
        return _unknown(name, f"{text}; the other way it cannot be judged from this motion")
    ends = np.degrees([-low, high])
    return Judgement(name, np.nan, ends[0], ends[1], "deg", Verdict.RIGHT, text)


def _hidden(
    measured: tuple[float, float], sign: float, effort: Effort, way: Way, model: Model, payload: str
) -> float:
    """Smallest wrong zero one way at which nominal and measured torque differ [rad]; or infinity."""
    away = np.arange(STEP, FARTHEST + 0.5 * STEP, STEP)
    positions = np.repeat(effort.middle[None], len(away), axis=0)
    positions[:, way.joint] += sign * away
    torque = torque_at_rest(model, positions, payload)[:, way.joint]
    low, high = measured
    ends = np.sort([torque / FACTOR, torque * FACTOR], axis=0)
    seen = np.flatnonzero((ends[1] < low) | (ends[0] > high))
    return float(away[seen[0]]) if len(seen) else np.inf
