"""Conversion of recordings from a controller's units and side of the gear to SI units of the joints."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arm.robot import Limits
from ..errors import BadUnit, RecordingError, UnknownKey, WrongShape
from .recording import Recording, Signal

FACTORS: dict[str, dict[str, float]] = {
    "rad": {"rad": 1.0, "mrad": 1e-3, "deg": np.pi / 180, "turn": 2 * np.pi},
    "rad/s": {"rad/s": 1.0, "deg/s": np.pi / 180, "rpm": np.pi / 30, "turn/s": 2 * np.pi},
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "m/s": {"m/s": 1.0, "mm/s": 1e-3},
    "A": {"A": 1.0, "mA": 1e-3},
    "N m": {"N m": 1.0, "mN m": 1e-3, "N mm": 1e-3},
    "N": {"N": 1.0},
    "degC": {"degC": 1.0, "K": 1.0},
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
}
"""Unit of `SIGNALS` -> units of that quantity, and their factors."""
OFFSETS = {"K": -273.15}
"""Unit whose zero is another -> offset of the conversion."""
UNITS: dict[str, tuple[str, float, float]] = {
    unit: (si, factor, OFFSETS.get(unit, 0.0))
    for si, factors_of_units in FACTORS.items()
    for unit, factor in factors_of_units.items()
}
"""Unit -> corresponding unit of `SIGNALS`, and factor and offset of the conversion."""

SPELLINGS: dict[str, str] = {
    "rad": "radian radians",
    "deg": "degree degrees grad grd °",
    "turn": "turns rev revolution revolutions",
    "rad/s": "rad/sec rads radians/s rad_s",
    "deg/s": "deg/sec degs degrees/s grad/s °/s deg_s",
    "rpm": "1/min min-1 u/min rev/min",
    "turn/s": "turns/s rev/s rps",
    "A": "amp amps ampere amperes",
    "mA": "milliamp milliamps",
    "N m": "newtonmeter newtonmeters",
    "degC": "°c c celsius",
    "K": "kelvin",
    "s": "sec secs second seconds sek",
    "ms": "msec millis millisecond milliseconds",
    "us": "µs μs usec micros microsecond microseconds",
    "ns": "nsec nanos nanosec nanosecond nanoseconds",
}
"""Unit -> its other spellings."""

TRAVEL = {"%": -100.0, "0-100%": 0.0}
"""Units of shares of a joint's travel -> their value at its lower limit; at the upper limit they are 100."""
PER_SECOND = "%/s"
"""Unit of the velocity that belongs to a position in "%"."""
_TRAVEL_UNITS = {"rad": [*TRAVEL], "m": [*TRAVEL], "rad/s": [PER_SECOND], "m/s": [PER_SECOND]}

ANGLES = ("rad", "rad/s")
"""Units of quantities that may be in degrees."""

OF_JOINT = ("position", "velocity", "link_position", "command", "command_velocity")
"""Signals that are a joint coordinate, or its rate."""
COMMANDS = {"command": "position", "command_velocity": "velocity"}
"""Command -> measured signal with the same unit."""

BEFORE_GEAR = ("position", "velocity", "command", "torque")
"""Signals that a controller may report for the motor: larger by the gear ratio, torque smaller."""


def unit_named(text: str) -> tuple[str, float, float] | None:
    """Entry of `UNITS`, regardless of case, spaces and brackets; None if there is none."""
    return _BY_NAME.get(_bare(text))


def is_travel(unit: str) -> bool:
    """Whether a unit is a share of a joint's travel."""
    return _bare(unit) in TRAVEL


def _bare(text: str) -> str:
    return re.sub(r"[\s.·⋅*]", "", text.lower().strip(" []()"))


_BY_NAME = {_bare(name): entry for name, entry in UNITS.items()}
_BY_NAME |= {_bare(name): UNITS[unit] for unit, names in SPELLINGS.items() for name in names.split()}


def percent_of_travel(limits: Limits, lowest: float | np.ndarray = -100.0) -> tuple[np.ndarray, np.ndarray]:
    """Scale and zero of positions in percent of each joint's travel: position = (value - zero) * scale.

    `lowest` is the value at the lower limit, one or shape (n,); at the upper limit it is 100. Returns the
    scale [rad or m per percent] and the value at position 0, shape (n,) each; NaN for joints without limits.
    """
    lower, upper = limits.position_lower, limits.position_upper
    travel = np.where(np.isfinite(upper) & np.isfinite(lower) & (upper > lower), upper - lower, np.nan)
    scale = travel / (100.0 - lowest)
    return scale, lowest - lower / scale


def factors(
    si: Sequence[str], units: Sequence[str], where: str, limits: Limits | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Factors and offsets, shape (n,) each, from the units of n joints to those in `si`; "" is that in `si`.

    Shares of travel need limits. The error is about a unit that is unknown or that of another quantity.
    """
    pairs = []
    for joint, (wanted, unit) in enumerate(zip(si, units, strict=True)):
        entry = unit_named(unit or wanted)
        if limits is not None and _bare(unit) in _TRAVEL_UNITS.get(wanted, ()):
            pairs.append(_travel_factor(_bare(unit), limits, joint, where))
        elif entry is None or entry[0] != wanted:
            raise BadUnit(f"{where}: unit '{unit}'; valid: {', '.join(units_of(wanted))}")
        else:
            pairs.append(entry[1:])
    return tuple(np.array(pairs).T)


def units_of(si: str) -> list[str]:
    """Names of the valid units of a quantity, including `si`."""
    return [*FACTORS.get(si, ()), *_TRAVEL_UNITS.get(si, ())]


def _travel_factor(unit: str, limits: Limits, joint: int, where: str) -> tuple[float, float]:
    """Factor and offset of a share of travel of one joint, or of its rate."""
    scale, zero = (values[joint] for values in percent_of_travel(limits, TRAVEL.get(unit, -100.0)))
    if not np.isfinite(scale):
        raise BadUnit(
            f"{where}: unit '{unit}' of joint {joint + 1} is a share of its travel, and the robot's "
            "description states no lower and upper limit; give [limits] position_lower and position_upper "
            "in robot.toml"
        )
    return float(scale), 0.0 if unit == PER_SECOND else float(-zero * scale)


def joint_side(recording: Recording, motor_side: bool | Sequence[str]) -> Recording:
    """Convert positions, velocities and torques of motors to those of joints, through gears and coupling.

    Motors turn by ratio * (coupling @ joints); by virtual work, joints get coupling^T @ (ratio * torque).
    `motor_side` names the signals of the motors; True stands for all of `BEFORE_GEAR`.
    """
    if isinstance(motor_side, bool):
        motor_side = BEFORE_GEAR if motor_side else ()
    for name in motor_side:
        if name not in BEFORE_GEAR:
            raise UnknownKey(name, "motor_side", BEFORE_GEAR)
    ratio, coupling = recording.robot.gear_ratio, recording.robot.coupling
    if motor_side and np.all(ratio == 1) and np.array_equal(coupling, np.eye(len(ratio))):
        raise RecordingError(
            f"{recording.name}: motor_side (--motor-side) needs the gears, but {recording.robot.name} has "
            "gear ratio 1 on every joint; give [drive] gear_ratio, motor turns per joint turn, in robot.toml"
        )
    angles = np.linalg.inv(coupling * ratio[:, None])
    torques = (coupling * ratio[:, None]).T
    return _scaled(recording, {name: torques if name == "torque" else angles for name in motor_side})


def to_axes_of_robot(
    recording: Recording, sign: Sequence[float] | None = None, zero: Sequence[float] | None = None
) -> Recording:
    """Convert a controller's coordinates to those of the robot's description: sign * position + zero.

    Torques and velocities only change their sign. Currents stay unchanged: the drive gain has their sign.
    Signs are 1 or -1, by default 1; zeros are positions in the robot's description at the controller's zero
    [rad; m].
    """
    n = recording.robot.dof
    signs = np.ones(n) if sign is None else np.asarray(sign, float)
    zeros = np.zeros(n) if zero is None else np.asarray(zero, float)
    if signs.shape != (n,) or zeros.shape != (n,) or not np.all(np.abs(signs) == 1):
        raise WrongShape(
            f"sign {sign} and zero {zero}: expected 1 or -1, and a position, for each of {n} joints"
        )
    turned = _scaled(recording, dict.fromkeys((*OF_JOINT, "torque"), signs))
    signals = dict(turned.signals)
    for name in ("position", "link_position", "command"):
        if name in signals:
            signals[name] = Signal(signals[name].time, signals[name].values + zeros)
    return replace(turned, signals=signals)


def _scaled(recording: Recording, factors: dict[str, np.ndarray]) -> Recording:
    """Recording with signals multiplied by a factor per joint (n,), or by a matrix (n, n) from the left."""
    signals = dict(recording.signals)
    for name, factor in factors.items():
        if name in signals:
            old = signals[name]
            # A diagonal matrix must not spread the NaN of one joint to all joints.
            diagonal = factor if factor.ndim == 1 else np.diag(factor)
            plain = factor.ndim == 1 or np.array_equal(factor, np.diag(diagonal))
            with np.errstate(over="ignore", invalid="ignore"):  # the checks find such numbers
                values = old.values * diagonal if plain else old.values @ factor.T
            signals[name] = Signal(old.time, values)
    return replace(recording, signals=signals)
