"""Escalation: what is asked of the driver where a stop does not do what it should.

    LISTENING    MOVING --- what is watched ---> BRAKING ---> HOLDING
        |           |                               |            |
        |           +--- fault, silence, link lost  |            |
        |                         |                 |            |
        +-----------------------> QUICK <-----------+------------+
                                    |
                                    +---> OFF

No driver and no clock in here: `signs.py` sees, `loop.py` asks the driver. A level is never taken back. What
`watch.py` finds at the level of a quick stop begins one in every state before QUICK, without waiting.
"""

from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple

import numpy as np

from exidyn.drivers import StopLevel

from ..frames import STAGES
from .stop import Stop


class State(Enum):
    """How far a stop has got; the value is a sentence about it."""

    LISTENING = "while nothing is commanded"
    MOVING = "while commands move the arm"
    BRAKING = "while commands brake the arm"
    HOLDING = "while commands hold the arm"
    QUICK = "after a quick stop"
    OFF = "after torque off was asked for"


class Sign(Enum):
    """Signs that a stop does not work, on any joint; the value is the kind of stop that follows."""

    ADRIFT = "motion without command"
    FASTER = "speed against a brake"
    BEHIND = "tracking error in a brake"
    AWAY = "tracking error at rest"
    OUTWARD = "motion beyond a limit"
    GOES_ON = "motion after a quick stop"
    CREEPS = "creep after a stop"
    FLANGE_CREEPS = "creep of the flange after a stop"


UNITS = {Sign.FASTER: "rad/s", Sign.FLANGE_CREEPS: "m"}
"""Of value and limit of a sign on a revolute joint; all others are in rad."""
SURE = 0.1
"""Twice the time over which a speed is a mean [s]: no jump of an encoder is taken for motion."""
SETTLING = 0.2
"""A position loop as slow as 2 Hz has lost nine tenths of its error by then [s]."""
SETTLED = 2.0 * SETTLING
"""And 99 % by then [s]: what moves on is no settling."""


class Rule(NamedTuple):
    """What follows from a sign.

    Attributes:
        seconds: How long it must have been seen without a break [s].
        level: What is asked of the driver then.
    """

    seconds: float
    level: StopLevel


RULES = {
    # Nothing is commanded that could brake, so that only the controller can.
    (State.LISTENING, Sign.ADRIFT): Rule(SURE, StopLevel.QUICK),
    # Commands slow down, and the arm does not.
    (State.BRAKING, Sign.FASTER): Rule(SURE, StopLevel.QUICK),
    (State.BRAKING, Sign.BEHIND): Rule(SURE, StopLevel.QUICK),
    (State.BRAKING, Sign.OUTWARD): Rule(SURE, StopLevel.QUICK),
    # Commands rest, and the arm does not, or not there.
    (State.HOLDING, Sign.FASTER): Rule(SURE, StopLevel.QUICK),
    (State.HOLDING, Sign.AWAY): Rule(SETTLING, StopLevel.QUICK),
    (State.HOLDING, Sign.OUTWARD): Rule(SURE, StopLevel.QUICK),
    (State.HOLDING, Sign.CREEPS): Rule(SURE, StopLevel.QUICK),
    (State.HOLDING, Sign.FLANGE_CREEPS): Rule(SURE, StopLevel.QUICK),
    # Well after the controller should have stopped the arm. Nothing less takes the torque away: arms drop.
    (State.QUICK, Sign.GOES_ON): Rule(SURE, StopLevel.OFF),
    (State.QUICK, Sign.CREEPS): Rule(SURE, StopLevel.OFF),
    (State.QUICK, Sign.FLANGE_CREEPS): Rule(SURE, StopLevel.OFF),
}
"""The whole table; what is not in it does nothing."""


class Sight(NamedTuple):
    """A sign as it is seen.

    Attributes:
        joint: Name of the joint that has shown it for longest.
        value: In `unit`.
        limit: Limit that the value is beyond.
        seconds: For how long without a break [s].
        unit: Unit of value and limit.
    """

    joint: str
    value: float
    limit: float
    seconds: float
    unit: str = "rad"


def state_of(level: int, stage: int) -> State:
    """The state of a stop, by the hardest `StopLevel` asked for, 0 for none, and the index in `STAGES`."""
    if level > StopLevel.BRAKE:
        return State.OFF if level == StopLevel.OFF else State.QUICK
    return _STATES[stage]


_MOVING = {"approaching": State.MOVING, "running": State.MOVING}
_STATES = [_MOVING.get(stage) or State[stage.upper()] for stage in STAGES]
WATCHED = {state: tuple(sign for at, sign in RULES if at is state) for state in State}
"""The signs that are looked for in a state."""


def escalate(state: State, sights: Mapping[Sign, Sight]) -> Stop | None:
    """What to ask of the driver now, by what has been seen for long enough; None for nothing new."""
    for sign in WATCHED[state]:
        seen = sights.get(sign)
        if seen is not None and seen.seconds >= RULES[state, sign].seconds:
            text = (
                f"{seen.joint}: {sign.value} of {seen.value:.4g} {seen.unit}, limit {seen.limit:.4g}, for "
                f"{seen.seconds:.2f} s {state.value}"
            )
            level = RULES[state, sign].level
            return Stop(level, sign.value, text, seen.joint, seen.value, seen.limit, seen.unit)
    return None


REACTION = 0.15
"""Within this time a quick stop shows in the measured speed [s]: the drives' delay (0.05 s), the mean of the
speed (0.05 s), and as much again for the ramp's own jerk."""
RAMP = 0.5
"""Share of the robot's deceleration that a controller's own quick stop has at least [-]: what a controller is
set to is not known here."""
LONGEST = 1.0
"""No quick stop of an arm that began within its speed limits takes longer [s]."""


def allowed_speed(before: np.ndarray, deceleration: np.ndarray, since: float) -> np.ndarray:
    """Speed that a quick stop may have left [rad/s], by speed before [rad/s] and limits [rad/s^2], (n,)."""
    return np.maximum(before - RAMP * deceleration * max(since - REACTION, 0.0), 0.0)


def stopping_distance(before: np.ndarray, deceleration: np.ndarray) -> np.ndarray:
    """Way of a quick stop at most [rad], by speed before [rad/s] and limits [rad/s^2], each shape (n,)."""
    return before * (REACTION + 0.5 * before / (RAMP * deceleration))


def overdue(before: np.ndarray, deceleration: np.ndarray, since: float) -> np.ndarray:
    """Whether a quick stop should have ended, shape (n,); see `allowed_speed`."""
    return since > REACTION + np.minimum(before / (RAMP * deceleration), LONGEST)
