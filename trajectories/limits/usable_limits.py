"""Usable limits: the robot's limits less safety margins, within which a planner stays."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Limits, Robot

from ..errors import BadLimits, Infeasible, in_words_of
from ..trajectory import UNITS, unit_of

HALF_TURN = np.pi
"""Range either way of a joint without position limits, so that cables do not wind up [rad]."""
SPEED_UP = 1.0
"""Time to full speed if the robot has no acceleration limit [s]: gentle for an arm that takes 0.3 s."""
BUILD_UP = 0.1
"""Time to full acceleration if the robot has no jerk limit [s]: ten times that of a fast controller."""


@dataclass(frozen=True)
class Margins:
    """Safety margins to each limit of the robot; limits that are assumed have no margin."""

    position: float = 0.05  # margin at both ends of a revolute joint [rad]
    slide: float = 0.01  # margin at both ends of a prismatic joint [m]
    velocity: float = 0.05  # share of the limit [-]
    acceleration: float = 0.05  # share of the limit [-]
    jerk: float = 0.05  # share of the limit [-]
    torque: float = 0.05  # share of the limit [-]

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            distance = name in ("position", "slide")
            if not (value >= 0.0 and value < (np.inf if distance else 1.0)):
                expected = "0 or more" if distance else "from 0 to below 1"
                raise BadLimits(f"margins: {name} is {value:g}; it must be {expected}")


class UsableLimits(NamedTuple):
    """Limits to plan within."""

    limits: Limits  # limits less margins; all except torque are finite
    assumed: tuple[str, ...]  # a sentence for each kind of limit that had to be assumed


def usable(
    robot: Robot,
    margins: Margins | None = None,
    window: np.ndarray | None = None,
    start: np.ndarray | None = None,
) -> UsableLimits:
    """The robot's limits that a planner may use.

    Args:
        robot: Robot with the limits of its data sheet or controller.
        margins: Safety margins; 0.05 rad and 5 % by default.
        window: Largest correction of each joint from the start pose that the controller allows (AXISCORR in
            RSI): shape (n,) if equal both ways, or (n, 2) for the most negative and most positive [rad]. It
            has no margin, since it bounds the command and not the measured position.
        start: Pose at which the motion begins, shape (n,) [rad]; required with a window.

    Raises:
        BadLimits: No joint can move within a limit, or a limit is missing and cannot be assumed.
        Infeasible: The start is outside the limits, or the margins leave no range.
    """
    margins, nominal = margins or Margins(), robot.limits
    with in_words_of(robot):
        require_movable(nominal)
        _require_speed(nominal)
        lower, upper, assumed = _positions(robot, margins)
        _require_room(lower, upper, "the margins leave nothing of the position limits. Try smaller margins")
        if start is not None:
            _require_inside(np.asarray(start, float), lower, upper)
        if window is not None:
            lower, upper = _in_window(lower, upper, np.asarray(window, float), start)
    velocity, backward = ((1 - margins.velocity) * v for v in (nominal.velocity, nominal.velocity_lower))
    missing = ~np.isfinite(nominal.acceleration), ~np.isfinite(nominal.acceleration_lower)
    share = 1 - margins.acceleration
    with np.errstate(invalid="ignore"):  # a missing limit is infinite
        forward = np.where(missing[0], velocity / SPEED_UP, share * nominal.acceleration)
        slowing = np.where(missing[1], backward / SPEED_UP, share * nominal.acceleration_lower)
    gentle = np.minimum(forward, -slowing) / BUILD_UP
    jerk = np.where(np.isfinite(nominal.jerk), (1 - margins.jerk) * nominal.jerk, gentle)
    torque = (1 - margins.torque) * nominal.torque
    reached = f"full speed within {SPEED_UP:g} s", f"full acceleration within {BUILD_UP:g} s"
    assumed += _sentence(robot, missing[0] | missing[1], f"acceleration limit; {reached[0]}")
    assumed += _sentence(robot, ~np.isfinite(nominal.jerk), f"jerk limit; {reached[1]}")
    limits = Limits(lower, upper, velocity, forward, jerk, torque, backward, slowing)
    return UsableLimits(limits, tuple(assumed))


LIMIT_FIELDS = {
    "position": ("position_lower", "position_upper"),
    "velocity": ("velocity_lower", "velocity"),
    "acceleration": ("acceleration_lower", "acceleration"),
    "jerk": ("jerk", "jerk"),
    "torque": ("torque", "torque"),
}
"""Fields of `Limits` with the lower and the upper limit of each quantity; a single one holds both ways."""


def ranges(limits: Limits) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Lower and upper limit of position, velocity, acceleration and jerk, each of shape (n,), by name."""
    pairs = {}
    for name in UNITS:
        lower, upper = LIMIT_FIELDS[name]
        high = getattr(limits, upper)
        pairs[name] = (-high if lower == upper else getattr(limits, lower), high)
    return pairs


def require_movable(limits: Limits) -> None:
    """Raise `BadLimits` for a limit of zero, NaN or the wrong sign, or position limits in the wrong order."""
    shapes = {name: np.shape(value) for name, value in vars(limits).items()}
    if set(shapes.values()) != {np.shape(limits.velocity)} or np.ndim(limits.velocity) != 1:
        raise BadLimits(f"limits of different shapes: {shapes}; expected one value per joint for each")
    for name in ("velocity", "velocity_lower", "acceleration", "acceleration_lower", "jerk", "torque"):
        quantity, backward = name.removesuffix("_lower"), name.endswith("_lower")
        values = getattr(limits, name) * (-1.0 if backward else 1.0)
        for joint in np.flatnonzero(~(values > 0.0)):
            raise BadLimits(
                f"joint {joint + 1}: {'backward ' if backward else ''}{quantity} limit {values[joint]:g} "
                f"{unit_of(quantity)}; no joint can move within it. Try the value of the data sheet, or "
                "leave it out if unknown"
            )
    for joint in np.flatnonzero(~(limits.position_lower < limits.position_upper)):
        raise BadLimits(
            f"joint {joint + 1}: lower position limit {limits.position_lower[joint]:g} is not below the "
            f"upper, {limits.position_upper[joint]:g} rad. Try to swap or correct them"
        )


def require_jerk(limits: Limits) -> None:
    """Raise `BadLimits` as `require_movable`, and for infinite jerk: drive accelerations must not jump."""
    require_movable(limits)
    for joint in np.flatnonzero(~np.isfinite(limits.jerk)):
        raise BadLimits(
            f"joint {joint + 1}: jerk limit {limits.jerk[joint]:g}; it must be finite. "
            "Try `usable`, which assumes one"
        )


def require_tick(tick: float) -> None:
    """Raise `BadLimits` unless the sampling period of the controller [s] is above 0 and finite."""
    if not 0.0 < tick < np.inf:
        raise BadLimits(
            f"the sampling period is {tick:g} s; it must be above 0 and finite. Try the cycle time of the "
            "controller, such as 0.002"
        )


def _require_speed(limits: Limits) -> None:
    for key in ("velocity", "velocity_lower"):
        for joint in np.flatnonzero(~np.isfinite(getattr(limits, key))):
            raise BadLimits(
                f"joint {joint + 1}: no velocity limit is given. Try `{key}` under [limits] in the robot "
                "file, or the velocity of its limit in the URDF"
            )


def _positions(robot: Robot, margins: Margins) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Position limits less margins; half a turn each way for joints without limits."""
    lower, upper = robot.limits.position_lower, robot.limits.position_upper
    endless = np.isinf(lower) & np.isinf(upper) & robot.revolute
    for joint in np.flatnonzero((np.isinf(lower) | np.isinf(upper)) & ~endless):
        raise BadLimits(
            f"joint {joint + 1}: position limits {lower[joint]:g} to {upper[joint]:g}; only a continuous "
            "joint may have none. Try to give both limits"
        )
    margin = np.where(robot.revolute, margins.position, margins.slide)
    lower = np.where(endless, -HALF_TURN, lower + margin)
    upper = np.where(endless, HALF_TURN, upper - margin)
    return lower, upper, _sentence(robot, endless, "position limit; half a turn each way")


def _in_window(
    lower: np.ndarray, upper: np.ndarray, window: np.ndarray, start: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Position limits within a window around the start pose."""
    n = len(lower)
    if start is None:
        raise BadLimits("a correction window is relative to the start pose, which is missing. Try to give it")
    if window.shape == (n,):
        window = np.stack([-window, window], axis=1)
    if window.shape != (n, 2):
        raise BadLimits(f"window of shape {window.shape}; expected ({n},) or ({n}, 2)")
    low, high = window.T
    for joint in np.flatnonzero(~((low <= 0) & (0 <= high) & (low < high))):
        raise BadLimits(
            f"joint {joint + 1}: correction window {low[joint]:g} to {high[joint]:g} rad; it must "
            "contain the start pose, 0, and have a width above 0. Try the limits of AXISCORR"
        )
    lower, upper = np.maximum(lower, start + low), np.minimum(upper, start + high)
    why = "the correction window leaves nothing of the position limits. Try another start or a wider window"
    _require_room(lower, upper, why)
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
            "rad, the position limits less the margin. Try a start inside, or a smaller margin"
        )


def _sentence(robot: Robot, affected: np.ndarray, text: str) -> list[str]:
    names = [robot.joints[joint] for joint in np.flatnonzero(affected)]
    return [f"{', '.join(names)}: no {text} is assumed"] if names else []
