"""Usable limits: what a planner keeps to of what the robot may do."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Limits, Robot

from ..errors import BadLimits, Infeasible, in_words_of

HALF_TURN = np.pi
"""How far a joint without position limits is turned each way, so that cables do not wind up [rad]."""
SPEED_UP = 1.0
"""Seconds to full speed where no acceleration is given: gentle for an arm that reaches it in 0.3 s."""
BUILD_UP = 0.1
"""Seconds to full acceleration where no jerk is given: ten times what a fast controller takes."""


@dataclass(frozen=True)
class Margins:
    """What is kept free of each limit that is given; what had to be assumed has no margin.

    Attributes:
        position: At both ends of a revolute joint [rad].
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
        assumed: A sentence for each kind of limit that is not given.
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
        BadLimits: A limit that no joint can move within, or that is not given and cannot be assumed.
        Infeasible: A start outside the limits, or nothing left of them.
    """
    margins, given = margins or Margins(), robot.limits
    with in_words_of(robot):
        require_movable(given)
        _require_speed(given)
        lower, upper, assumed = _positions(robot, margins)
        _require_room(lower, upper, "the margins leave nothing of the position limits. Try smaller margins")
        if start is not None:
            _require_inside(np.asarray(start, float), lower, upper)
        if window is not None:
            lower, upper = _in_window(lower, upper, np.asarray(window, float), start)
    velocity, backward = ((1 - margins.velocity) * v for v in (given.velocity, given.velocity_lower))
    missing = ~np.isfinite(given.acceleration), ~np.isfinite(given.acceleration_lower)
    share = 1 - margins.acceleration
    with np.errstate(invalid="ignore"):  # a share of infinity where not given
        forward = np.where(missing[0], velocity / SPEED_UP, share * given.acceleration)
        slowing = np.where(missing[1], backward / SPEED_UP, share * given.acceleration_lower)
    gentle = np.minimum(forward, -slowing) / BUILD_UP
    jerk = np.where(np.isfinite(given.jerk), (1 - margins.jerk) * given.jerk, gentle)
    torque = (1 - margins.torque) * given.torque
    assumed += _sentence(
        robot, missing[0] | missing[1], f"acceleration limit; full speed within {SPEED_UP:g} s"
    )
    assumed += _sentence(
        robot, ~np.isfinite(given.jerk), f"jerk limit; full acceleration within {BUILD_UP:g} s"
    )
    limits = Limits(lower, upper, velocity, forward, jerk, torque, backward, slowing)
    return UsableLimits(limits, tuple(assumed))


def ranges(limits: Limits) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Lower and upper limit of position, velocity, acceleration and jerk, each of shape (n,), by name."""
    return {
        "position": (limits.position_lower, limits.position_upper),
        "velocity": (limits.velocity_lower, limits.velocity),
        "acceleration": (limits.acceleration_lower, limits.acceleration),
        "jerk": (-limits.jerk, limits.jerk),
    }


def require_movable(limits: Limits) -> None:
    """Raise unless every joint has room to move; infinity is room, but not where it cannot be checked.

    Raises:
        BadLimits: A limit of zero, NaN or the wrong sign, or a lower position limit not below the upper.
    """
    shapes = {name: np.shape(value) for name, value in vars(limits).items()}
    if set(shapes.values()) != {np.shape(limits.velocity)} or np.ndim(limits.velocity) != 1:
        raise BadLimits(f"limits of different shapes: {shapes}; expected one value a joint for each")
    sizes = (
        ("velocity", "rad/s", limits.velocity),
        ("backward velocity", "rad/s", -limits.velocity_lower),
        ("acceleration", "rad/s^2", limits.acceleration),
        ("backward acceleration", "rad/s^2", -limits.acceleration_lower),
        ("jerk", "rad/s^3", limits.jerk),
        ("torque", "N m", limits.torque),
    )
    for what, unit, values in sizes:
        for joint in np.flatnonzero(~(values > 0.0)):
            raise BadLimits(
                f"joint {joint + 1}: {what} limit {values[joint]:g} {unit}; "
                "no joint can move within it. Try the value of the data sheet, or leave it out if unknown"
            )
    for joint in np.flatnonzero(~(limits.position_lower < limits.position_upper)):
        raise BadLimits(
            f"joint {joint + 1}: lower position limit {limits.position_lower[joint]:g} is not below the "
            f"upper, {limits.position_upper[joint]:g} rad. Try to swap or correct them"
        )


def require_jerk(limits: Limits) -> None:
    """Raise as `require_movable`, or where the jerk is not limited: no acceleration of a drive may jump.

    Raises:
        BadLimits: An infinite jerk limit, or one that no joint can move within.
    """
    require_movable(limits)
    for joint in np.flatnonzero(~np.isfinite(limits.jerk)):
        raise BadLimits(
            f"joint {joint + 1}: jerk limit {limits.jerk[joint]:g}; a move needs a finite one. "
            "Try `usable`, which assumes one"
        )


def require_tick(tick: float) -> None:
    """Raise unless a cycle of the controller [s] is above 0 and finite.

    Raises:
        BadLimits: It is not.
    """
    if not 0.0 < tick < np.inf:
        raise BadLimits(
            f"a tick of {tick:g} s; it must be above 0. Try the cycle of the controller, such as 0.002"
        )


def _require_speed(limits: Limits) -> None:
    for key, values in (("velocity", limits.velocity), ("velocity_lower", limits.velocity_lower)):
        for joint in np.flatnonzero(~np.isfinite(values)):
            raise BadLimits(
                f"joint {joint + 1}: no velocity limit is given. Try `{key}` under [limits] in the robot "
                "file, or the velocity of its limit in the URDF"
            )


def _positions(robot: Robot, margins: Margins) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Position limits less margins; half a turn each way where there are none."""
    lower, upper = robot.limits.position_lower, robot.limits.position_upper
    endless = np.isinf(lower) & np.isinf(upper) & robot.revolute
    for joint in np.flatnonzero((np.isinf(lower) | np.isinf(upper)) & ~endless):
        raise BadLimits(
            f"joint {joint + 1}: position limits {lower[joint]:g} to {upper[joint]:g}; only a joint that "
            "turns without end may have none. Try both limits"
        )
    margin = np.where(robot.revolute, margins.position, margins.slide)
    assumed = _sentence(robot, endless, "position limit; half a turn each way")
    return (
        np.where(endless, -HALF_TURN, lower + margin),
        np.where(endless, HALF_TURN, upper - margin),
        assumed,
    )


def _in_window(
    lower: np.ndarray, upper: np.ndarray, window: np.ndarray, start: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Position limits within a window around the start pose."""
    n = len(lower)
    if start is None:
        raise BadLimits("a correction window is around the start pose. Try to give the start pose with it")
    if window.shape == (n,):
        window = np.stack([-window, window], axis=1)
    if window.shape != (n, 2):
        raise BadLimits(f"window of shape {window.shape}; expected ({n},) or ({n}, 2)")
    low, high = window.T
    for joint in np.flatnonzero(~((low <= 0) & (0 <= high) & (low < high))):
        raise BadLimits(
            f"joint {joint + 1}: correction window {low[joint]:g} to {high[joint]:g} rad; it must "
            "hold the start pose, at 0, and be wider than nothing. Try the limits of AXISCORR"
        )
    lower, upper = np.maximum(lower, start + low), np.minimum(upper, start + high)
    _require_room(
        lower, upper, "nothing is left in the correction window. Try another start or a wider window"
    )
    return lower, upper


def _require_room(lower: np.ndarray, upper: np.ndarray, why: str) -> None:
    for joint in np.flatnonzero(~(lower < upper)):
        raise Infeasible(f"joint {joint + 1}: {lower[joint]:g} to {upper[joint]:g} rad: {why}")


def _require_inside(start: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> None:
    if start.shape != lower.shape:
        raise BadLimits(
            f"start pose of shape {start.shape}; expected one position for each of {len(lower)} joints"
        )
    for joint in np.flatnonzero(~((lower <= start) & (start <= upper))):
        raise Infeasible(
            f"joint {joint + 1}: start {start[joint]:g} is outside {lower[joint]:g} to {upper[joint]:g} "
            "rad, the position limits less margin. Try a start inside, or a smaller margin"
        )


def _sentence(robot: Robot, which: np.ndarray, text: str) -> list[str]:
    names = [robot.joints[joint] for joint in np.flatnonzero(which)]
    return [f"{', '.join(names)}: no {text} is assumed"] if names else []
