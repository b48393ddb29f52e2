"""Escalation: which harder stop is requested from the driver if a stop does not work.

    LISTENING    MOVING --- what is watched ---> BRAKING ---> HOLDING
        |           |                               |            |
        |           +--- fault, silence, link lost  |            |
        |                         |                 |            |
        +-----------------------> QUICK <-----------+------------+
                                    |
                                    +---> OFF

This module has neither driver nor clock: `signs.py` observes, and `loop.py` calls the driver. A level is
never taken back. A quick stop by `watch.py` begins at once in every state before QUICK.
"""

from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple

import numpy as np

from exidyn.drivers import StopLevel

from .stop import Stop
from .watch import WatchLimits


class State(Enum):
    """Progress of a stop; the value is a phrase for messages."""

    LISTENING = "while nothing is commanded"
    MOVING = "while commands move the arm"
    BRAKING = "while commands brake the arm"
    HOLDING = "while commands hold the arm"
    QUICK = "after a quick stop"
    OFF = "after torque off was requested"


class Sign(Enum):
    """Signs on a joint that a stop does not work; the value is the kind of the stop that follows."""

    ADRIFT = "motion without command"
    FASTER = "speed against a brake"
    BEHIND = "tracking error in a brake"
    AWAY = "tracking error at rest"
    OUTWARD = "motion beyond a limit"
    MOVES_ON = "motion after a quick stop"
    CREEPS = "creep after a stop"
    FLANGE_CREEPS = "creep of the flange after a stop"


UNITS = {Sign.FASTER: "rad/s", Sign.FLANGE_CREEPS: "m"}
"""Units of a sign's value and limit on revolute joints; signs not listed here are in rad."""
MIN_DURATION = 0.1
"""Duration after which motion is certain [s]: twice the averaging window of speeds, so that a jump of an
encoder does not count as motion."""
SETTLING = 0.2
"""Time after which a position loop as slow as 2 Hz has lost 90 % of its error [s]."""
SETTLED = 2.0 * SETTLING
"""Time after which it has lost 99 % [s]: later motion is not settling."""
CREEP_LIMIT = 0.1
"""Distance that no load, spring or swing explains [rad]: six degrees."""
SWING_LIMIT = 0.2
"""Distance beyond any swing of an arm on soft springs after a quick stop [rad]: twice `CREEP_LIMIT`."""
FLANGE_LIMIT = 0.01
"""Distance of the flange that counts as motion [m], in one direction and after the arm should be at rest: a
person who holds the flange would notice it, and a settling position loop moves less."""
BRAKING_FACTOR = 2.0
"""Multiple of the tracking limit allowed during a controlled stop, which may still reduce the error [-]."""


class Rule(NamedTuple):
    """Response to a sign."""

    seconds: float  # duration for which the sign must be seen without interruption [s]
    level: StopLevel  # stop that is then requested from the driver


RULES = {
    # There are no commands that could stop the arm, so the controller must.
    (State.LISTENING, Sign.ADRIFT): Rule(MIN_DURATION, StopLevel.QUICK),
    # The commands slow down, but the arm does not.
    (State.BRAKING, Sign.FASTER): Rule(MIN_DURATION, StopLevel.QUICK),
    (State.BRAKING, Sign.BEHIND): Rule(MIN_DURATION, StopLevel.QUICK),
    (State.BRAKING, Sign.OUTWARD): Rule(MIN_DURATION, StopLevel.QUICK),
    # The commands rest, but the arm moves or is elsewhere.
    (State.HOLDING, Sign.FASTER): Rule(MIN_DURATION, StopLevel.QUICK),
    (State.HOLDING, Sign.AWAY): Rule(SETTLING, StopLevel.QUICK),
    (State.HOLDING, Sign.OUTWARD): Rule(MIN_DURATION, StopLevel.QUICK),
    (State.HOLDING, Sign.CREEPS): Rule(MIN_DURATION, StopLevel.QUICK),
    (State.HOLDING, Sign.FLANGE_CREEPS): Rule(MIN_DURATION, StopLevel.QUICK),
    # The controller should have stopped the arm long ago. Nothing less removes the torque, since arms drop.
    (State.QUICK, Sign.MOVES_ON): Rule(MIN_DURATION, StopLevel.OFF),
    (State.QUICK, Sign.CREEPS): Rule(MIN_DURATION, StopLevel.OFF),
    (State.QUICK, Sign.FLANGE_CREEPS): Rule(MIN_DURATION, StopLevel.OFF),
}
"""Rules by state and sign; other combinations have no response."""


def sign_limits(watch: WatchLimits) -> dict[Sign, float]:
    """Limit of each sign, in rad on revolute joints unless `UNITS` has another unit.

    That of `FASTER` follows from the commanded speed in every cycle.
    """
    return {
        Sign.ADRIFT: CREEP_LIMIT,
        Sign.BEHIND: BRAKING_FACTOR * watch.tracking,
        Sign.AWAY: watch.tracking,
        Sign.OUTWARD: watch.outside,
        Sign.MOVES_ON: SWING_LIMIT,
        Sign.CREEPS: CREEP_LIMIT,
        Sign.FLANGE_CREEPS: FLANGE_LIMIT,
    }


class Sight(NamedTuple):
    """An observed sign."""

    joint: str  # name of the joint that has shown the sign for longest
    value: float  # measured value, in `unit`
    limit: float  # limit that the value exceeds, in `unit`
    seconds: float  # duration without interruption [s]
    unit: str = "rad"  # unit of value and limit


def state_of(level: int, stage: int) -> State:
    """State of a stop, from the hardest `StopLevel` requested (0 for none) and the index in `STAGES`."""
    if level > StopLevel.BRAKE:
        return State.OFF if level == StopLevel.OFF else State.QUICK
    return _STATES[stage]


_STATES = (State.LISTENING, State.MOVING, State.MOVING, State.BRAKING, State.HOLDING)  # as in `STAGES`
WATCHED = {state: tuple(sign for rule_state, sign in RULES if rule_state is state) for state in State}
"""Signs to look for in each state."""


def escalate(state: State, sights: Mapping[Sign, Sight]) -> Stop | None:
    """The stop to request because a sign has been seen for long enough; None if there is none."""
    for sign in WATCHED[state]:
        sight = sights.get(sign)
        if sight is not None and sight.seconds >= RULES[state, sign].seconds:
            text = (
                f"{sight.joint}: {sign.value} of {sight.value:.4g} {sight.unit}, limit {sight.limit:.4g}, "
                f"for {sight.seconds:.2f} s {state.value}"
            )
            level = RULES[state, sign].level
            return Stop(level, sign.value, text, sight.joint, sight.value, sight.limit, sight.unit)
    return None


REACTION = 0.15
"""Time within which a quick stop shows in the measured speed [s]: 0.05 s each for the drives' delay, for the
averaging of the speed, and for the jerk of the ramp."""
RAMP = 0.5
"""Minimum deceleration of a controller's quick stop, as a share of the robot's limit [-]; the controller's
setting is unknown."""
MAX_QUICK_STOP = 1.0
"""Maximum duration of a quick stop from within the speed limits [s]."""


def allowed_speed(before: np.ndarray, deceleration: np.ndarray, since: float) -> np.ndarray:
    """Allowed speed in a quick stop [rad/s], from initial speed [rad/s] and limits [rad/s^2], shape (n,)."""
    return np.maximum(before - RAMP * deceleration * max(since - REACTION, 0.0), 0.0)


def stopping_distance(before: np.ndarray, deceleration: np.ndarray) -> np.ndarray:
    """Maximum distance of a quick stop [rad], from initial speed [rad/s] and limits [rad/s^2], shape (n,)."""
    return before * (REACTION + 0.5 * before / (RAMP * deceleration))


def overdue(before: np.ndarray, deceleration: np.ndarray, since: float) -> np.ndarray:
    """Whether a quick stop should have ended by now, shape (n,); see `allowed_speed`."""
    return since > REACTION + np.minimum(before / (RAMP * deceleration), MAX_QUICK_STOP)
