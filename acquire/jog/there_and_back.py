"""There and back: one joint slowly, from where the arm stands and to there again; and the cycles of it."""

from dataclasses import dataclass, replace

import numpy as np

from exidyn.identification.arm.robot import Limits, Robot
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.families.sequence import Sequence
from exidyn.trajectories.limits.moves import move
from exidyn.trajectories.limits.usable_limits import Margins, usable
from exidyn.trajectories.trajectory import State, whole_ticks

from ..run.errors import CannotStart, NotAllowed
from ..run.frames import SAMPLE, Unframed, read_cycle
from ..run.player import BRAKING, RUNNING
from ..terminal.joint_units import JointUnits

TURN, SLIDE = float(np.radians(2.0)), 0.01
"""Speed [rad/s], [m/s]. 2 degrees a second move the end of a 3 m arm at 105 mm/s, less than half of the 250
that ISO 10218-1 allows with a person near; who reacts after a second sees two degrees more."""
SHARE = 0.05
"""Of the velocity limit that is not passed either [-]: small joints are slower still."""
USUAL_TURN, USUAL_SLIDE = float(np.radians(2.0)), 0.005
"""Default way [rad], [m]: more than the play of a gear, and little where something is near."""
MOST_TURN, MOST_SLIDE = float(np.radians(10.0)), 0.05
"""Longest way [rad], [m]: beyond it a joint is no longer tried out but moved."""
SPEED_UP, BUILD_UP = 0.25, 0.1
"""Time to the crawl, and to the acceleration of it [s]: no jerk that a person or a gear would feel."""
BEFORE, BETWEEN = 2.0, 0.5
"""Rest before, in which a person reads what comes, and at the far end [s]."""


@dataclass(frozen=True)
class Way:
    """What one joint, by its column, is to do: a signed distance [rad] or [m] at a speed [rad/s] or [m/s]."""

    joint: int
    distance: float
    speed: float

    @classmethod
    def of(cls, robot: Robot, joint: int, distance: float) -> "Way":
        """The way at the crawl of this joint.

        Raises:
            NotAllowed: It is longer than the longest, or none.
        """
        revolute = bool(robot.revolute[joint])
        most, crawl = (MOST_TURN, TURN) if revolute else (MOST_SLIDE, SLIDE)
        units = JointUnits.of(robot)
        scale, unit = units.scale[joint], units.units[joint]
        if not 0.0 < abs(distance) <= most * (1.0 + 1e-9):
            raise NotAllowed(
                f"{robot.joints[joint]}: {scale * distance:g} {unit}; a jog goes up to {scale * most:g} "
                f"{unit} either way, and not 0. For more plan a motion with exidyn excite"
            )
        limit = min(robot.limits.velocity[joint], -robot.limits.velocity_lower[joint])
        return cls(joint, distance, min(crawl, SHARE * float(limit)))


def require_room(robot: Robot, way: Way, position: np.ndarray) -> None:
    """Raise where the joint would leave its limits, or is not known to be within them.

    Raises:
        CannotStart: It would; names both positions.
    """
    joint, units = way.joint, JointUnits.of(robot)
    target = position.copy()
    target[joint] += way.distance
    unknown = [name for name, value in zip(robot.joints, position, strict=True) if not np.isfinite(value)]
    if unknown:
        raise CannotStart(f"the controller gives no position of {', '.join(unknown)}; see exidyn watch")
    for what, place in (("stands at", position), ("would go to", target)):
        if units.beyond(place)[joint]:
            raise CannotStart(
                f"{robot.joints[joint]} {what} {units.text(place, joint)}, its limits are "
                f"{units.range_text(joint)} {units.units[joint]}. Jog it the other way, or look at its zero"
            )


def there_and_back(position: np.ndarray, way: Way, limits: Limits, tick: float) -> Sequence:
    """Rest, the way, rest, the way back, from a position (n,) within `run_limits`; tick in [s]."""
    slow = _crawling(limits, way)
    far = position.copy()
    far[way.joint] += way.distance
    here, there = State.at_rest(position), State.at_rest(far)
    return Sequence(
        (
            Phases.hold(position, whole_ticks(BEFORE, tick)),
            move(here, there, slow, tick),
            Phases.hold(far, whole_ticks(BETWEEN, tick)),
            move(there, here, slow, tick),
        )
    )


def run_limits(robot: Robot) -> Limits:
    """The robot's limits; rates that are not given as the planner assumes them."""
    assumed = usable(robot, Margins(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)).limits
    positions = robot.limits.position_lower, robot.limits.position_upper
    return replace(assumed, position_lower=positions[0], position_upper=positions[1])


def duration(way: Way) -> float:
    """About how long it takes [s]."""
    return BEFORE + BETWEEN + 2.0 * (abs(way.distance) / way.speed + SPEED_UP + BUILD_UP)


def _crawling(limits: Limits, way: Way) -> Limits:
    """No joint faster than the crawl, and no more acceleration than brings it there."""
    speed, push = way.speed, way.speed / SPEED_UP
    small = {"velocity": speed, "acceleration": push, "jerk": push / BUILD_UP}
    upper = {name: np.minimum(getattr(limits, name), value) for name, value in small.items()}
    lower = {
        f"{name}_lower": np.maximum(getattr(limits, f"{name}_lower"), -small[name])
        for name in ("velocity", "acceleration")
    }
    return replace(limits, **upper, **lower)


@dataclass(frozen=True)
class Course:
    """What was commanded and measured while the motion was played, up to the end of a stop.

    Attributes:
        commanded: Positions, shape (t, n) [rad] or [m].
        speed: Commanded velocities, shape (t, n) [rad/s] or [m/s].
        position: Measured, shape (t, n); NaN where a joint was silent.
        velocity: Shape (t, n); NaN where it is not measured.
        current: Shape (t, n) [A].
        torque: Shape (t, n) [N m].
    """

    commanded: np.ndarray
    speed: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    current: np.ndarray
    torque: np.ndarray


class Kept:
    """A sink that keeps every cycle; a jog is short."""

    failure = ""

    def __init__(self) -> None:
        self._frames: list[bytes] = []

    def put(self, frame: bytes) -> None:
        """Keep a frame, and look at it later: the loop has no time."""
        self._frames.append(frame)

    def close(self) -> None:
        """Nothing to do."""

    def course(self) -> Course:
        """What was kept; without cycles where nothing was commanded."""
        frames = Unframed()
        cycles = [read_cycle(body) for kind, body in frames.add(b"".join(self._frames)) if kind == SAMPLE]
        moved = [one for one in cycles if one.stage in (RUNNING, BRAKING)]
        sent = [one for one in moved if np.isfinite(one.array("command_position")).all()]
        names = ("command_position", "command_velocity", "position", "velocity", "current", "torque")
        return Course(*(np.array([one.array(name) for one in sent]) for name in names))
