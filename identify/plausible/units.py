"""Units of time, position and velocity, from speeds, limits and velocity columns.

The module also reports other properties of the samples: rate, gaps, and effects of encoders and recorders.
"""

from collections.abc import Collection
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid

from ..arm.robot import Robot
from ..recordings.misread_columns import in_percent
from ..recordings.units import FACTORS, percent_of_travel
from ..text_table import digits
from .samples import runs_of

TIME = FACTORS["s"]
TURNING = {"rad": 1.0, "deg": np.pi / 180}
SLIDING = {"m": 1.0, "mm": 1e-3}
TRAVEL = "%"
"""Percent of a joint's travel: -100 and 100 at its limits."""
UNUSUAL_PAIR = np.log(0.1)
"""Log probability of radians beside millimeters or degrees beside meters: controllers with linear axes use
degrees and millimeters, simulations radians and meters."""
NORMALIZED = np.log(0.1)
"""Log probability that a log without a stated unit has percent of travel, as some recorders write."""
PERCENT, LEAST_PERCENT = 100.5, 30.0
"""Maximum value in percent of travel, with a tolerance; and minimum that distinguishes it from radians."""
RATE = (250.0, 6.0)
"""Sampling rate of logs [Hz], median and factor: two thirds are in the range from 40 Hz to 1.5 kHz."""
SPEED = (0.3, 4.0)
"""Highest speed in a log over the joint's limit, median and factor."""
RANGE = (0.3, 4.0)
"""Largest range in a log over that of the joint's limits, median and factor."""
USUAL_SPEED = (3.0, 1.0)
"""Speed limit if the robot states none, for revolute [rad/s] and prismatic joints [m/s]."""
USUAL_RANGE = (2 * np.pi, 1.0)
"""Range of motion if the robot states no limits, for revolute [rad] and prismatic joints [m]."""
ENDLESS = 20.0
"""Range relative to `USUAL_RANGE` up to which a joint without limits is plausible; more suggests degrees."""
OVER = 0.1
"""Relative tolerance of a limit: encoders may read slightly more than controllers enforce."""
BEYOND = np.log(0.01)
"""Log probability that a log in the right unit exceeds a speed or range by more than the tolerance."""
OTHER_UNIT = 0.01
"""Probability that a log has positions in encoder counts, motor turns, or another unlisted unit."""
ANY = np.log(1e3)
"""Standard deviation of the logarithm of speeds and ranges in an unlisted unit."""
AGREES = 0.05
"""Relative error of the ratio between a velocity column and the derivative of position."""
NOT_DERIVED = 0.01
"""Probability that a velocity column is not the derivative of the position."""
SAME_BITS = 2e-3
"""Tolerance of the binary logarithm of an encoder's steps per turn, compared with an integer."""
BINARY = -np.log(2 * SAME_BITS)
"""Log odds of a unit in which steps per turn are a power of two, which is rare by chance."""
STATED = 0.99
"""Probability that a unit in a column's name is right."""
STEPS = 5
"""Number of sampling periods over which speeds are computed, to limit the effect of timestamp jitter."""
COARSE = 0.3
"""Share of equal successive values beyond which the resolution of an encoder is visible."""
REPEATED = 0.3
"""Share of samples in motion that repeat the previous one on all joints, beyond which a note is made."""


class Units(NamedTuple):
    """A hypothesis about units: a key of `TIME`, and those of position and velocity, see `pair`."""

    time: str
    position: str
    velocity: str


FREE = Units("", "", "")
"""No units that are certain."""


class Moves(NamedTuple):
    """Properties of the motion in a log, in the units of the log."""

    period: float  # median step of the time column
    speed: np.ndarray  # high speed (99.5th percentile) of each joint, shape (n,)
    reach: np.ndarray  # difference of the highest and lowest position, shape (n,)
    ratio: float  # derivative of position over velocity column; NaN without a column, or if they disagree
    step: np.ndarray  # encoder resolution, shape (n,); NaN if it is not visible


def moves(time: np.ndarray, position: np.ndarray, velocity: np.ndarray | None) -> Moves:
    """Speeds and ranges of a log; time (t,) increases, position and velocity are (t, n)."""
    # Use intervals far above encoder resolution and timestamp jitter, which may be a whole sampling period.
    stride = max(STEPS, len(time) // 2000) if len(time) > 10 * STEPS else 1
    steps = np.diff(time[::stride])[:, None]
    speeds = np.diff(position[::stride], axis=0) / steps
    ratio = np.nan
    if velocity is not None:
        traveled = cumulative_trapezoid(velocity, time, axis=0, initial=0.0)
        means = np.diff(traveled[::stride], axis=0) / steps
        along, across = float((speeds * means).sum()), float((means**2).sum())
        if along > 0.9 * np.sqrt(across * (speeds**2).sum()) > 0.0:
            ratio = along / across
    fast = np.percentile(np.abs(speeds), 99.5, axis=0)
    period, step = float(np.median(np.diff(time))), encoder_steps(position)
    return Moves(period, fast, np.ptp(position, axis=0), ratio, step)


def encoder_steps(position: np.ndarray) -> np.ndarray:
    """Resolution of each encoder from positions (t, n), shape (n,); NaN if it is not visible."""
    return np.array([_step(column) for column in position.T])


def _step(position: np.ndarray) -> float:
    """Resolution of an encoder: all changes of position (t,) are multiples of it; NaN if there is none."""
    changes = np.abs(np.diff(position))
    least = changes[changes > 0].min(initial=np.inf)
    small = changes[(changes > 0) & (changes < 20 * least)] / least
    if len(small) < 20 or np.mean(np.abs(small - np.round(small)) < 0.02) < 0.95:
        return np.nan
    return float(least * (small @ np.round(small)) / (np.round(small) @ np.round(small)))


def pair(unit: str) -> tuple[str, str]:
    """Units of revolute and prismatic joints: `deg mm` names both; beside `deg` or `mm` the other is SI."""
    named = unit.split()
    turning, sliding = ([name for name in named if name in known] for known in (TURNING, SLIDING))
    return (*turning, "rad")[0], (*sliding, "m")[0]


def affine(robot: Robot, unit: str, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Scale and offset of each joint's position, shape (n,) each: position = scale * value + offset.

    In percent of travel, a gripper whose values (t, n) are never negative has the range 0 to 100.
    """
    if unit != TRAVEL:
        turning, sliding = pair(unit)
        return np.where(robot.revolute, TURNING[turning], SLIDING[sliding]), np.zeros(robot.dof)
    scale, zero = percent_of_travel(robot.limits, np.where(_openings(robot, position), 0.0, -100.0))
    return scale, -zero * scale


def _openings(robot: Robot, position: np.ndarray) -> list[bool]:
    """Whether the percentages (t, n) of each joint are those of a gripper's opening."""
    pairs = zip(robot.joints, position.T, strict=True)
    return [in_percent(joint, values) and float(np.nanmin(values)) >= 0.0 for joint, values in pairs]


def units_of(robot: Robot, unit: str, per: str = "", position: np.ndarray | None = None) -> list[str]:
    """Unit of each joint's position, or of its velocity with "/s".

    The values of positions (t, n) show which joints are grippers, if they are percentages.
    """
    if unit == TRAVEL:
        openings = [False] * robot.dof if position is None else _openings(robot, position)
        return [f"0-100{unit}" if opening else unit + per for opening in openings]
    turning, sliding = pair(unit)
    turning, sliding = ("rpm" if unit == "rpm" else turning + per), sliding + per
    return [turning if revolute else sliding for revolute in robot.revolute.tolist()]


def of_travel(robot: Robot, position: np.ndarray) -> bool:
    """Whether positions (t, n) may be percent of travel: all joints have limits, and no value is beyond."""
    limits = robot.limits
    span = limits.position_upper - limits.position_lower
    return bool(np.isfinite(span).all() and LEAST_PERCENT < np.nanmax(np.abs(position)) < PERCENT)


def encoder_odds(step: np.ndarray, scale: np.ndarray) -> float:
    """Log odds of a unit, from the share of encoders whose steps per turn are then a power of two.

    Args:
        step: Encoder resolution of each revolute joint in the unit of the log, shape (n,); NaN if not
            visible.
        scale: Radians per unit, shape (n,).
    """
    angles = scale * step
    bits = np.log2(2 * np.pi / angles[angles > 0.0])
    return BINARY * float(np.mean(np.abs(bits - np.round(bits)) < SAME_BITS)) if len(bits) else 0.0


def unit_odds(seen: Moves, robot: Robot, values: np.ndarray, stated: Units) -> dict[Units, float]:
    """Log of prior times likelihood of each combination of units.

    `seen` and positions (t, n) are in the units of the log; column names state the units `stated`, "" for
    none.
    """
    turning, place = bool(robot.revolute.any()), 0 if robot.revolute.any() else 1
    known = (TURNING, SLIDING)[place]
    angles = list(known) + [TRAVEL] * of_travel(robot, values)
    if turning and not robot.revolute.all():
        angles += [f"{unit} mm" for unit in TURNING]
    odds = {}
    for time, position in product(TIME, angles):
        scale, _ = affine(robot, position, values)
        base = _stated(time, stated.time, TIME)
        for unit, units in zip(pair(position), (TURNING, SLIDING), strict=True):
            named = "".join(word for word in stated.position.split() if word in units)
            base += _stated(TRAVEL if position == TRAVEL else unit, named, units)
        base += NORMALIZED * (position == TRAVEL) + UNUSUAL_PAIR * _is_unusual(robot, position)
        base += log_normal(1.0 / (seen.period * TIME[time]), RATE[0], np.log(RATE[1]))
        for kind in filter(np.any, (robot.revolute, ~robot.revolute)):
            fast, reach = seen.speed * scale / TIME[time], seen.reach * scale
            base += motion_odds(fast * kind, reach * kind, robot)
        base += encoder_odds(seen.step[robot.revolute], scale[robot.revolute])
        # Percent of travel belongs to all joints.
        rates = {unit: known.get(unit if unit == TRAVEL else pair(unit)[place], 1.0) for unit in angles}
        rates |= {"rpm": np.pi / 30} if turning else {}
        for velocity, rate in rates.items():
            # Without a stated unit, velocities are expected in that of positions.
            alike = stated.velocity in ("", *position.split())
            value = base + _stated(velocity, position if alike else stated.velocity, rates)
            if np.isfinite(seen.ratio):
                matching = position == velocity
                expected = TIME[time] * (1.0 if matching else rate / float(np.median(scale)))
                agreeing = np.exp(log_normal(seen.ratio, expected, AGREES))
                value += float(np.log((1 - NOT_DERIVED) * agreeing + NOT_DERIVED / 30))  # over 13 decades
            odds[Units(time, position, velocity)] = value
    return odds


def with_fixed(odds: dict[Units, float], fixed: Units) -> dict[Units, float]:
    """Odds of the combinations that have the fixed units; "" stands for a unit that is free."""
    kept = {
        units: value
        for units, value in odds.items()
        if all(
            # Degrees of revolute joints leave the unit of prismatic ones free.
            known in ("", part) or (known == "deg" and known in part.split())
            for known, part in zip(fixed, units, strict=True)
        )
    }
    return kept or odds


def _is_unusual(robot: Robot, unit: str) -> bool:
    """Whether revolute and prismatic joints are in units that are seldom used together."""
    both = robot.revolute.any() and not robot.revolute.all() and unit != TRAVEL
    return bool(both) and pair(unit) not in (("rad", "m"), ("deg", "mm"))


def log_normal(value: float, middle: float, spread: float) -> float:
    """Log of the density of log(value), normal about log(middle) with standard deviation `spread`."""
    return float(-0.5 * (np.log(value / middle) / spread) ** 2 - np.log(spread * np.sqrt(2 * np.pi)))


def _stated(unit: str, stated: str, units: Collection[str]) -> float:
    """Log prior of a unit: a stated unit is right in most logs; otherwise all units are equally probable."""
    if stated not in units:
        return 0.0
    return float(np.log(STATED if unit == stated else (1 - STATED) / (len(units) - 1)))


def other_unit_odds(seen: Moves, robot: Robot, values: np.ndarray, units: Units) -> float:
    """Log odds that positions are in an unlisted unit, relative to the given units."""
    scale, _ = affine(robot, units.position, values)
    known = motion_odds(seen.speed * scale / TIME[units.time], seen.reach * scale, robot)
    anywhere = 2 * log_normal(1.0, 1.0, ANY)
    return float(np.log(OTHER_UNIT / (1 - OTHER_UNIT)) + anywhere - known)


def motion_odds(fastest_seen: np.ndarray, reach_seen: np.ndarray, robot: Robot) -> float:
    """Log-likelihood of highest speeds and of ranges of motion, shape (n,) each, given the limits."""
    limits, revolute = robot.limits, robot.revolute
    usual_speed, usual_range = (np.where(revolute, *usual) for usual in (USUAL_SPEED, USUAL_RANGE))
    fastest = np.where(np.isfinite(limits.velocity), limits.velocity, usual_speed)
    span = limits.position_upper - limits.position_lower
    endless = ~np.isfinite(span)
    span = np.where(endless, usual_range, span)
    speed = float(np.max(fastest_seen / fastest))
    shares = reach_seen / span
    reach = float(np.max(np.where(endless & (shares < ENDLESS), np.minimum(shares, 1.0), shares)))
    odds = 0.0
    for share, (middle, spread) in ((speed, SPEED), (reach, RANGE)):
        odds += log_normal(max(share, 1e-9), middle, np.log(spread)) + BEYOND * (share > 1 + OVER)
    return odds


def quirks(time: np.ndarray, position: np.ndarray, robot: Robot) -> list[str]:
    """Notes about the samples, from time (t,) [s] and position (t, n) [rad]."""
    runs, steps = runs_of(time), np.diff(time)
    period = float(np.median(steps))
    steps = np.delete(steps, [run.stop - 1 for run in runs[:-1]])
    in_runs = f" in {len(runs)} runs" if len(runs) > 1 else ""
    notes = [f"{len(time)} samples at {digits(1 / period)} Hz, {digits(steps.sum())} s{in_runs}"]
    change = np.abs(np.diff(position, axis=0))
    moving = change.max(axis=1) > 0
    repeated = float(np.mean(~moving[np.argmax(moving) : len(moving) - np.argmax(moving[::-1])]))
    if moving.any() and repeated > REPEATED:
        notes.append(f"{100 * repeated:.0f} % of the samples repeat all positions of the previous one")
    for joint, column in zip(robot.joints, change.T, strict=True):
        notes += _encoder(joint, column, robot.revolute[robot.index(joint)])
    return notes


def at_rest(joint: str) -> str:
    """Note about a joint that stands still."""
    return f"{joint} does not move"


def _encoder(joint: str, change: np.ndarray, revolute: bool) -> list[str]:
    """Notes about one joint, from the sizes of its steps, shape (t - 1,)."""
    moved = change[change > 1e-9]
    if not len(moved):
        return [at_rest(joint)]
    notes = []
    if np.mean(change <= 1e-9) > COARSE and len(np.unique(np.round(moved / moved.min()))) < 50:
        unit = "rad" if revolute else "m"
        notes.append(f"{joint} is read in steps of {moved.min():.2g} {unit}")
    return notes
