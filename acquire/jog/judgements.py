"""Judgements of a jogged joint, each with a measured value, the expected range, and the verdict."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from exidyn.identification.model import Model

from .effort import Effort, effort_of, torque_at_rest
from .there_and_back import Course, Travel

NO_PART = 0.1
"""Share of the travel below which a joint counts as standing, and by which the jogged joint may miss its
travel [-]. Wrong settings differ by a factor or a sign; play, springs and coarse encoders stay below: two
counts of 4096 per turn are 0.18 degrees."""
FEWEST = 0.25
"""Share of the travel that must have been commanded before a stop for a judgement [-]."""
DEVIATIONS = 3.0
"""Standard deviations from which a value counts as nonzero: chance alone reaches this once in 400."""
FACTOR = 4.0 / 3.0
"""Largest acceptable factor between measured and nominal torque [-]: masses and gains of data sheets are more
accurate, and a gain for peak instead of r.m.s. current (1.41), or half the gain, is outside."""
FARTHEST = np.radians(30)
"""Largest encoder offset that is examined [rad]; if only a larger one would show, the zero is unknown."""
STEP = np.radians(1)
"""Step of the examined encoder offsets [rad]."""
OF_WAY = "of the way"
"""Unit of a share of the commanded travel."""
ROUNDING = 1e-9
"""Torque below which terms cancel up to rounding [N m]."""
NOT_GONE = "the joint did not move as commanded, so its torque belongs to another motion"


class Verdict(StrEnum):
    """Verdict on one property."""

    RIGHT = "right"
    WRONG = "WRONG"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class Judgement:
    """Judgement of one property."""

    name: str  # name of the property
    value: float  # measured value; NaN if unknown
    low: float  # smallest acceptable value
    high: float  # largest acceptable value
    unit: str  # unit of the values
    verdict: Verdict  # verdict on the property
    text: str = ""  # reason, and what to check; empty if the numbers suffice


def judge(course: Course, travel: Travel, model: Model, payload: str = "") -> list[Judgement]:
    """All judgements of a jog, compared with the nominal model; `payload` is the payload's name, or empty."""
    joints = model.robot.joints
    commanded = course.commanded[:, travel.joint] if len(course.commanded) else np.zeros(1)
    if np.ptp(commanded) < FEWEST * abs(travel.distance):
        why = f"{joints[travel.joint]} was stopped before a quarter of its travel was commanded"
        return [Judgement("way", np.nan, 1 - NO_PART, 1 + NO_PART, OF_WAY, Verdict.UNKNOWN, why)]
    shares = _shares(course, travel.joint)
    judgements = [_own_travel(shares, travel.joint), _other_travel(shares, travel.joint, joints)]
    effort = effort_of(course, travel, model) if judgements[0].verdict is Verdict.RIGHT else NOT_GONE
    if isinstance(effort, str):
        names = ("friction with the motion", "gravity torque", "encoder zero")
        return judgements + [_unknown(name, effort) for name in names]

    def nominal(offsets: np.ndarray) -> np.ndarray:
        """Nominal torque at rest in the middle of the travel, with these encoder offsets (t,) [rad]."""
        positions = np.repeat(effort.middle[None], len(offsets), axis=0)
        positions[:, travel.joint] += offsets
        return torque_at_rest(model, positions, payload)[:, travel.joint]

    friction = _friction(effort)
    gravity, measured = _gravity(effort, friction, float(nominal(np.zeros(1))[0]))
    zero = _unknown("encoder zero", "cannot be judged from this motion")
    if gravity.verdict is Verdict.RIGHT and model.robot.revolute[travel.joint]:
        zero = _zero(*(_hidden(measured, sign, nominal) for sign in (-1.0, 1.0)))
    return [*judgements, friction, gravity, zero]


def _shares(course: Course, joint: int) -> np.ndarray:
    """Each joint's share of the commanded travel, by least squares over the motion, shape (n,) [-]."""
    commanded = course.commanded[:, joint]
    shares = np.full(course.position.shape[1], np.nan)
    for other in range(len(shares)):
        known = np.isfinite(course.position[:, other])
        away = commanded[known] - commanded[known].mean() if known.any() else commanded[:0]
        if away.size and away @ away > 0.0:
            shares[other] = away @ course.position[known, other] / (away @ away)
    return shares


def _own_travel(shares: np.ndarray, joint: int) -> Judgement:
    share = float(shares[joint])
    low, high = 1.0 - NO_PART, 1.0 + NO_PART
    if low <= share <= high:
        return Judgement("way", share, low, high, OF_WAY, Verdict.RIGHT)
    if abs(share) <= NO_PART:
        text = (
            "the joint did not move: check brake and drive, and whether its encoder belongs to another joint"
        )
    elif share < 0.0:
        text = "the joint moved against the command: the signs of encoder and command differ"
    else:
        text = "the scale is wrong: check counts, gear ratio and resolution in the controller's settings"
    return Judgement("way", share, low, high, OF_WAY, Verdict.WRONG, text)


def _other_travel(shares: np.ndarray, joint: int, joints: tuple[str, ...]) -> Judgement:
    name = "largest way of another joint"
    others = np.where(np.arange(len(shares)) == joint, 0.0, np.abs(np.nan_to_num(shares)))
    worst = int(np.argmax(others))
    value = float(others[worst])
    if value <= NO_PART:
        return Judgement(name, value, 0.0, NO_PART, OF_WAY, Verdict.RIGHT)
    text = (
        f"{joints[worst]} moved as well: check the order of the joints in the settings, or a coupling that "
        "the controller does not compensate"
    )
    return Judgement(name, value, 0.0, NO_PART, OF_WAY, Verdict.WRONG, text)


def _unknown(name: str, why: str) -> Judgement:
    return Judgement(name, np.nan, np.nan, np.nan, "", Verdict.UNKNOWN, why)


def _friction(effort: Effort) -> Judgement:
    """Half the torque difference between there and back: gravity cancels, drives push with the motion."""
    name, least = "friction with the motion", DEVIATIONS * effort.friction_std
    value, verdict, text = effort.friction, Verdict.RIGHT, ""
    if abs(value) <= least:
        verdict, text = Verdict.UNKNOWN, "friction is below the noise"
    elif value < 0.0:
        verdict = Verdict.WRONG
        text = f"the drive seems to push against the motion: the sign of {effort.source}"
    return Judgement(name, value, least, np.inf, effort.unit, verdict, text)


def _gravity(effort: Effort, friction: Judgement, nominal: float) -> tuple[Judgement, tuple[float, float]]:
    """Mean torque of there and back, in which friction cancels, compared with the nominal torque at rest."""
    name, unit = "gravity torque", effort.unit
    nominal = nominal if abs(nominal) > ROUNDING else 0.0
    low, high = sorted((nominal / FACTOR, nominal * FACTOR))
    uncertainty = abs(effort.friction) + DEVIATIONS * effort.gravity_std
    value = effort.gravity
    interval = (value - uncertainty, value + uncertainty)
    verdict, text = Verdict.RIGHT, ""
    if interval[1] < low or interval[0] > high:
        verdict, text = Verdict.WRONG, _why_gravity(effort, friction, nominal)
    elif abs(nominal) < uncertainty or not low <= value <= high:
        verdict = Verdict.UNKNOWN
        text = (
            f"friction may shift it by {uncertainty:.3g} {unit}, and the nominal torque is "
            f"{abs(nominal):.3g} {unit}: jog it where gravity is larger"
        )
    return Judgement(name, value, low, high, unit, verdict, text), interval


def _why_gravity(effort: Effort, friction: Judgement, nominal: float) -> str:
    where = "the load on the flange (--mass), masses in the robot file, the zero or the order of the joints"
    if effort.gravity * nominal < 0.0:
        if friction.verdict is Verdict.WRONG:
            return f"opposite to nominal, as is friction: check the sign of {effort.source}"
        return f"opposite to nominal: check the joint's sign or zero, or {where}"
    if abs(nominal) < effort.friction_std:
        return f"the nominal torque is zero here: check {where}"
    return f"{effort.gravity / nominal:.2f} of the nominal torque: check {effort.source}, or {where}"


def _zero(low: float, high: float) -> Judgement:
    """Encoder offsets at which the gravity torque would differ, if gain and masses are nominal.

    They are the smallest in either direction [rad]; infinity if none would differ.
    """
    name = "encoder zero"
    if not np.isfinite(low) and not np.isfinite(high):
        offset = f"an offset of {np.degrees(FARTHEST):g} degrees"
        return _unknown(
            name, f"cannot be judged from this motion: {offset} would give the same gravity torque"
        )
    shows = [f"{np.degrees(end):+.0f}" for end in (-low, high) if np.isfinite(end)]
    text = (
        f"an offset of {' or '.join(shows)} degrees would give another gravity torque, if gain and masses "
        "are right"
    )
    if len(shows) < 2:
        return _unknown(name, f"{text}; in the other direction it cannot be judged from this motion")
    ends = np.degrees([-low, high])
    return Judgement(name, np.nan, ends[0], ends[1], "deg", Verdict.RIGHT, text)


def _hidden(measured: tuple[float, float], sign: float, nominal: Callable[[np.ndarray], np.ndarray]) -> float:
    """Smallest encoder offset of one sign at which nominal and measured torque differ [rad]; or infinity."""
    offsets = np.arange(STEP, FARTHEST + 0.5 * STEP, STEP)
    torque = nominal(sign * offsets)
    low, high = measured
    ends = np.sort([torque / FACTOR, torque * FACTOR], axis=0)
    differing = np.flatnonzero((ends[1] < low) | (ends[0] > high))
    return float(offsets[differing[0]]) if len(differing) else np.inf
