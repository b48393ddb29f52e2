"""Usable limits: what a planner keeps to of what the robot may do."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from exidyn.identify.arm.robot import Limits, Robot

from ..errors import BadLimits, Infeasible

HALF_TURN = np.pi
"""How far a joint without position limits is turned each way, so that cables do not wind up [rad]."""
SPEED_UP = 1.0
"""Seconds to full speed where no acceleration is given: gentle for an arm that reaches it in 0.3 s."""
BUILD_UP = 0.1
"""Seconds to full acceleration where no jerk is given: ten times what a fast controller takes."""


@dataclass(frozen=True)
class Margins:
    """What is kept free of each limit that is said; what had to be assumed has no margin.

    Attributes:
        position: At both ends of a joint that turns [rad].
        slide: At both ends of a joint that slides [m].
        velocity: Share of the limit [-].
        acceleration: Share of the limit [-].
        jerk: Share of the limit [-].
        torque: Share of the limit [-].
    """

    position: float = 0.05
    slide: float = 0.01
    velocity: float = 0.05
    acceleration: float = 0.05
    jerk: float = 0.05
    torque: float = 0.05

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            length = name in ("position", "slide")
            if not (value >= 0.0 and value < (np.inf if length else 1.0)):
                wanted = "0 or more" if length else "from 0 to below 1"
                raise BadLimits(f"margins: {name} is {value:g}; it must be {wanted}")


class UsableLimits(NamedTuple):
    """Limits to plan within.

    Attributes:
        limits: Margins taken off; everything but the torque is finite.
        assumed: A sentence for each kind of limit that nobody said.
    """

    limits: Limits
    assumed: tuple[str, ...]


def usable(
    robot: Robot,
    margins: Margins | None = None,
    window: np.ndarray | None = None,
    start: np.ndarray | None = None,
) -> UsableLimits:
    """What a planner may use of the robot's limits.

    Args:
        robot: Its limits are those of the data sheet or the controller.
        margins: What to keep free; the usual 0.05 rad and 5 % unless given.
        window: How far the controller lets each joint be moved from the start pose (RSI's AXISCORR): shape
            (n,) for both ways alike, or (n, 2) for the most negative and most positive [rad]. It has no
            margin, since it bounds the command and not the measured position.
        start: Pose at which the motion begins, shape (n,) [rad]; needed with a window.

    Raises:
        BadLimits: A limit that no joint can move within, or that is not said and cannot be assumed.
        Infeasible: A start outside the limits, or nothing left of them.
    """
    margins = margins or Margins()
    given = robot.limits
    require_movable(given, robot)
    _require_speed(given, robot)
    lower, upper, assumed = _positions(robot, margins)
    _require_room(
        robot, lower, upper, "the margins leave nothing of the position limits. Try smaller margins"
    )
    if start is not None:
        _require_inside(robot, np.asarray(start, float), lower, upper)
    if window is not None:
        lower, upper = _in_window(robot, lower, upper, np.asarray(window, float), start)
    velocity, backward = ((1 - margins.velocity) * v for v in (given.velocity, given.velocity_lower))
    accelerations, unsaid = _accelerations(robot, margins, velocity, backward)
    assumed += unsaid
    jerk = _jerk(given.jerk, margins, *accelerations)
    assumed += _sentence(
        robot, ~np.isfinite(given.jerk), f"jerk limit; full acceleration within {BUILD_UP:g} s"
    )
    torque = (1 - margins.torque) * given.torque
    limits = Limits(lower, upper, velocity, accelerations[0], jerk, torque, backward, accelerations[1])
    return UsableLimits(limits, tuple(assumed))


def require_movable(limits: Limits, robot: Robot | None = None) -> None:
    """Raise unless every joint has room to move; infinity is room, but not where nobody could ask.

    Raises:
        BadLimits: A limit of zero, NaN or the wrong sign, or a lower position limit not below the upper.
    """
    shapes = {name: np.shape(value) for name, value in vars(limits).items()}
    if set(shapes.values()) != {np.shape(limits.velocity)} or np.ndim(limits.velocity) != 1:
        raise BadLimits(f"limits of different shapes: {shapes}; expected one value a joint for each")
    for what, order, values in _sizes(limits):
        for joint in _which(~(values > 0.0)):
            raise BadLimits(
                f"{_name(robot, joint)}: {what} limit {values[joint]:g} {_unit(robot, joint, order)}; "
                "no joint can move within it. Try the value of the data sheet, or leave it out if unknown"
            )
    for joint in _which(~(limits.position_lower < limits.position_upper)):
        raise BadLimits(
            f"{_name(robot, joint)}: lower position limit {limits.position_lower[joint]:g} is not below the "
            f"upper, {limits.position_upper[joint]:g} {_unit(robot, joint, 0)}. Try to swap or correct them"
        )


def require_jerk(limits: Limits, robot: Robot | None = None) -> None:
    """Raise where the jerk is not limited: nothing that is asked of a drive may jump in acceleration.

    Raises:
        BadLimits: An infinite jerk limit.
    """
    for joint in _which(~np.isfinite(limits.jerk)):
        raise BadLimits(
            f"{_name(robot, joint)}: jerk limit {limits.jerk[joint]:g}; a move needs a finite one. "
            "Try `usable`, which assumes one"
        )


def _sizes(limits: Limits) -> Iterable[tuple[str, int, np.ndarray]]:
    """Name, order of derivative (or -1 for torque) and size of the limits that must be above zero."""
    return (
        ("velocity", 1, limits.velocity),
        ("backward velocity", 1, -limits.velocity_lower),
        ("acceleration", 2, limits.acceleration),
        ("backward acceleration", 2, -limits.acceleration_lower),
        ("jerk", 3, limits.jerk),
        ("torque", -1, limits.torque),
    )


def _require_speed(limits: Limits, robot: Robot) -> None:
    for key, values in (("velocity", limits.velocity), ("velocity_lower", limits.velocity_lower)):
        for joint in _which(~np.isfinite(values)):
            raise BadLimits(
                f"{robot.joints[joint]}: no velocity limit is given. Try `{key}` under [limits] in the robot "
                "file, or the velocity of its limit in the URDF"
            )


def _positions(robot: Robot, margins: Margins) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Position limits less margins; half a turn each way where there are none."""
    lower, upper = robot.limits.position_lower, robot.limits.position_upper
    endless = np.isinf(lower) & np.isinf(upper) & robot.revolute
    for joint in _which((np.isinf(lower) | np.isinf(upper)) & ~endless):
        raise BadLimits(
            f"{robot.joints[joint]}: position limits {lower[joint]:g} to {upper[joint]:g}; only a joint that "
            "turns without end may have none. Try both limits"
        )
    margin = np.where(robot.revolute, margins.position, margins.slide)
    assumed = _sentence(robot, endless, "position limit; half a turn each way")
    return (
        np.where(endless, -HALF_TURN, lower + margin),
        np.where(endless, HALF_TURN, upper - margin),
        assumed,
    )


def _accelerations(
    robot: Robot, margins: Margins, velocity: np.ndarray, backward: np.ndarray
) -> tuple[tuple[np.ndarray, np.ndarray], list[str]]:
    given = robot.limits
    unsaid = ~np.isfinite(given.acceleration), ~np.isfinite(given.acceleration_lower)
    share = 1 - margins.acceleration
    with np.errstate(invalid="ignore"):  # a share of infinity where nobody said
        upper = np.where(unsaid[0], velocity / SPEED_UP, share * given.acceleration)
        lower = np.where(unsaid[1], backward / SPEED_UP, share * given.acceleration_lower)
    text = f"acceleration limit; full speed within {SPEED_UP:g} s"
    return (upper, lower), _sentence(robot, unsaid[0] | unsaid[1], text)


def _jerk(given: np.ndarray, margins: Margins, upper: np.ndarray, lower: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(given), (1 - margins.jerk) * given, np.minimum(upper, -lower) / BUILD_UP)


def _in_window(
    robot: Robot, lower: np.ndarray, upper: np.ndarray, window: np.ndarray, start: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Position limits within a window around the start pose."""
    if start is None:
        raise BadLimits("a correction window is around the start pose. Try to give the start pose with it")
    if window.shape == (robot.dof,):
        window = np.stack([-window, window], axis=1)
    if window.shape != (robot.dof, 2):
        raise BadLimits(f"window of shape {window.shape}; expected ({robot.dof},) or ({robot.dof}, 2)")
    for joint in _which(~((window[:, 0] <= 0) & (0 <= window[:, 1]) & (window[:, 0] < window[:, 1]))):
        low, high = window[joint]
        raise BadLimits(
            f"{robot.joints[joint]}: correction window {low:g} to {high:g} {_unit(robot, joint, 0)}; it must "
            "hold the start pose, at 0, and be wider than nothing. Try the limits of AXISCORR"
        )
    lower, upper = np.maximum(lower, start + window[:, 0]), np.minimum(upper, start + window[:, 1])
    _require_room(
        robot, lower, upper, "nothing is left in the correction window. Try another start or a wider window"
    )
    return lower, upper


def _require_room(robot: Robot, lower: np.ndarray, upper: np.ndarray, why: str) -> None:
    for joint in _which(~(lower < upper)):
        raise Infeasible(
            f"{robot.joints[joint]}: {lower[joint]:g} to {upper[joint]:g} {_unit(robot, joint, 0)}: {why}"
        )


def _require_inside(robot: Robot, start: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> None:
    if start.shape != (robot.dof,):
        raise BadLimits(
            f"start pose of shape {start.shape}; expected one position for each of {robot.dof} joints"
        )
    for joint in _which(~((lower <= start) & (start <= upper))):
        raise Infeasible(
            f"{robot.joints[joint]}: start {start[joint]:g} is outside {lower[joint]:g} to {upper[joint]:g} "
            f"{_unit(robot, joint, 0)}, the position limits less margin. "
            "Try a start inside, or a smaller margin"
        )


def _sentence(robot: Robot, which: np.ndarray, text: str) -> list[str]:
    names = [robot.joints[joint] for joint in _which(which)]
    return [f"{', '.join(names)}: no {text} is assumed"] if names else []


def _which(joints: np.ndarray) -> list[int]:
    return [int(joint) for joint in np.flatnonzero(joints)]


def _name(robot: Robot | None, joint: int) -> str:
    return f"joint {joint + 1}" if robot is None else robot.joints[joint]


def _unit(robot: Robot | None, joint: int, order: int) -> str:
    turns = robot is None or bool(robot.revolute[joint])
    if order < 0:
        return "N m" if turns else "N"
    return ("rad" if turns else "m") + ("", "/s", "/s^2", "/s^3")[order]
