"""Motion of a jog: one joint slowly from its current position and back; and the recorded cycles."""

from dataclasses import dataclass, replace

import numpy as np

from exidyn.identification.arm.robot import Limits, Robot
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.families.sequence import Sequence
from exidyn.trajectories.limits.moves import move
from exidyn.trajectories.limits.usable_limits import usable
from exidyn.trajectories.trajectory import State, whole_ticks

from ..run.before import NO_MARGIN
from ..run.errors import CannotStart, NotAllowed
from ..run.frames import SAMPLE, Unframed, read_cycle
from ..run.player import BRAKING, RUNNING
from ..terminal.watch_text import JointUnits

TURN, SLIDE = float(np.radians(2.0)), 0.01
"""Speed of revolute [rad/s] and prismatic joints [m/s]. At 2 degrees/s the end of a 3 m arm moves at
105 mm/s, less than half of the 250 mm/s that ISO 10218-1 allows near a person, and within a reaction time of
one second the joint moves two degrees."""
SHARE = 0.05
"""Largest share of the velocity limit [-]: joints with a low limit move more slowly."""
USUAL_TURN, USUAL_SLIDE = float(np.radians(2.0)), 0.005
"""Default travel [rad], [m]: more than the play of a gear, but little if an obstacle is near."""
MOST_TURN, MOST_SLIDE = float(np.radians(10.0)), 0.05
"""Longest travel [rad], [m]: a longer motion is not a test of one joint and needs a plan."""
SPEED_UP, BUILD_UP = 0.25, 0.1
"""Time to reach the speed, and to reach the acceleration [s], so that the jerk is small."""
BEFORE, BETWEEN = 2.0, 0.5
"""Rest before the motion, in which a person reads what follows, and at the far end [s]."""


@dataclass(frozen=True)
class Travel:
    """Commanded travel of one joint."""

    joint: int  # index of the joint
    distance: float  # signed distance [rad] or [m]
    speed: float  # speed [rad/s] or [m/s]

    @classmethod
    def of(cls, robot: Robot, joint: int, distance: float) -> "Travel":
        """Travel of a joint at its jog speed.

        Raises:
            NotAllowed: If the distance is zero or too long.
        """
        revolute = bool(robot.revolute[joint])
        longest, speed = (MOST_TURN, TURN) if revolute else (MOST_SLIDE, SLIDE)
        units = JointUnits.of(robot)
        scale, unit = units.scale[joint], units.units[joint]
        if not 0.0 < abs(distance) <= longest * (1.0 + 1e-9):
            raise NotAllowed(
                f"{robot.joints[joint]}: {scale * distance:g} {unit}; a jog goes up to {scale * longest:g} "
                f"{unit} in either direction, and not 0. Plan a longer motion with exidyn excite"
            )
        limit = min(robot.limits.velocity[joint], -robot.limits.velocity_lower[joint])
        return cls(joint, distance, min(speed, SHARE * float(limit)))


def require_room(robot: Robot, travel: Travel, position: np.ndarray) -> None:
    """Raise if the joint is or would be outside its limits, or if a position is unknown.

    Raises:
        CannotStart: If so; the message names the position and the limits.
    """
    joint, units = travel.joint, JointUnits.of(robot)
    target = position.copy()
    target[joint] += travel.distance
    unknown = [name for name, value in zip(robot.joints, position, strict=True) if not np.isfinite(value)]
    if unknown:
        raise CannotStart(f"the controller gives no position of {', '.join(unknown)}; see exidyn watch")
    for verb, place in (("stands at", position), ("would go to", target)):
        if units.beyond(place)[joint]:
            raise CannotStart(
                f"{robot.joints[joint]} {verb} {units.text(place, joint)}, its limits are "
                f"{units.range_text(joint)} {units.units[joint]}. Jog it in the other direction, or check "
                "its zero"
            )


def there_and_back(position: np.ndarray, travel: Travel, limits: Limits, tick: float) -> Sequence:
    """The motion from a position and back, with a rest before and between.

    Args:
        position: Current position, shape (n,) [rad] or [m].
        travel: Travel of the joint.
        limits: Limits of `run_limits`.
        tick: Sampling period [s].
    """
    slow = _slow_limits(limits, travel)
    target = position.copy()
    target[travel.joint] += travel.distance
    start, end = State.at_rest(position), State.at_rest(target)
    return Sequence(
        (
            Phases.hold(position, whole_ticks(BEFORE, tick)),
            move(start, end, slow, tick),
            Phases.hold(target, whole_ticks(BETWEEN, tick)),
            move(end, start, slow, tick),
        )
    )


def run_limits(robot: Robot) -> Limits:
    """The robot's limits; missing ones as the planner assumes them."""
    assumed = usable(robot, NO_MARGIN).limits
    positions = robot.limits.position_lower, robot.limits.position_upper
    return replace(assumed, position_lower=positions[0], position_upper=positions[1])


def duration(travel: Travel) -> float:
    """Approximate duration of the motion [s]."""
    return BEFORE + BETWEEN + 2.0 * (abs(travel.distance) / travel.speed + SPEED_UP + BUILD_UP)


def _slow_limits(limits: Limits, travel: Travel) -> Limits:
    """The limits, with velocity, acceleration and jerk reduced to those of the jog."""
    speed, acceleration = travel.speed, travel.speed / SPEED_UP
    small = {"velocity": speed, "acceleration": acceleration, "jerk": acceleration / BUILD_UP}
    upper = {name: np.minimum(getattr(limits, name), value) for name, value in small.items()}
    lower = {
        f"{name}_lower": np.maximum(getattr(limits, f"{name}_lower"), -small[name])
        for name in ("velocity", "acceleration")
    }
    return replace(limits, **upper, **lower)


@dataclass(frozen=True)
class Course:
    """Commanded and measured samples of the motion, up to the end of a stop."""

    commanded: np.ndarray  # commanded positions, shape (t, n) [rad] or [m]
    speed: np.ndarray  # commanded velocities, shape (t, n) [rad/s] or [m/s]
    position: np.ndarray  # measured positions, shape (t, n) [rad] or [m]; NaN for a silent joint
    velocity: np.ndarray  # measured velocities, shape (t, n) [rad/s] or [m/s]; NaN if not measured
    current: np.ndarray  # measured currents, shape (t, n) [A]; NaN if not measured
    torque: np.ndarray  # measured torques, shape (t, n) [N m]; NaN if not measured


class MemorySink:
    """A sink that keeps every cycle in memory, since a jog is short."""

    failure = ""

    def __init__(self) -> None:
        self._frames: list[bytes] = []

    def put(self, frame: bytes) -> None:
        """Keep a frame without reading it: the loop has no time."""
        self._frames.append(frame)

    def close(self) -> None:
        """Nothing to do."""

    def course(self) -> Course:
        """The samples of all cycles with a command."""
        frames = Unframed()
        cycles = [read_cycle(body) for kind, body in frames.add(b"".join(self._frames)) if kind == SAMPLE]
        moving = [cycle for cycle in cycles if cycle.stage in (RUNNING, BRAKING)]
        commanded = [cycle for cycle in moving if np.isfinite(cycle.array("command_position")).all()]
        names = ("command_position", "command_velocity", "position", "velocity", "current", "torque")
        return Course(*(np.array([cycle.array(name) for cycle in commanded]) for name in names))
