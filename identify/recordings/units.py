"""Recordings in the unit or on the side of the gear that a controller reports, turned into the joint's SI."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..errors import RecordingError, UnknownKey, WrongShape
from .recording import Recording, Signal

ANGLES = ("position", "velocity", "link_position", "command")
"""Signals that are angles of the joint, or their rate."""

BEFORE_GEAR = ("position", "velocity", "command", "torque")
"""Signals that a controller may report of the motor: by the gear ratio too large, torque too small."""


def to_radians(recording: Recording) -> Recording:
    """Take angles for degrees; joints that slide stay as they are."""
    factor = np.where(recording.robot.revolute, np.pi / 180, 1.0)
    return _changed(recording, {name: factor for name in ANGLES})


def joint_side(recording: Recording, motor_side: bool | Sequence[str]) -> Recording:
    """Refer the motor's positions, velocities and torques to the joint, through gear ratio and coupling.

    Motors turn by ratio * (coupling @ joints); by virtual work joints feel coupling^T @ (ratio * torque).

    Args:
        recording: In which the signals named are the motor's.
        motor_side: Names of signals; True for all that can be.

    Raises:
        UnknownKey: A name that is no signal of a motor.
        RecordingError: The robot has no gears.
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
    return _changed(recording, {name: torques if name == "torque" else angles for name in motor_side})


def to_axes_of_robot(
    recording: Recording, sign: Sequence[float] | None = None, zero: Sequence[float] | None = None
) -> Recording:
    """Turn a controller's joint coordinates into those of the robot's description: sign * position + zero.

    Torques and velocities take the sign alone. Currents stay the motor's: the drive gain has their sign.

    Args:
        recording: In the controller's coordinates.
        sign: 1 or -1 a joint; all 1 by default.
        zero: Position in the robot's description where the controller shows zero [rad], [m].

    Raises:
        WrongShape: Not one value a joint, or a sign that is neither 1 nor -1.
    """
    n = recording.robot.dof
    signs = np.ones(n) if sign is None else np.asarray(sign, float)
    zeros = np.zeros(n) if zero is None else np.asarray(zero, float)
    if signs.shape != (n,) or zeros.shape != (n,) or not np.all(np.abs(signs) == 1):
        raise WrongShape(
            f"sign {sign} and zero {zero}: expected 1 or -1, and a position, for each of {n} joints"
        )
    turned = _changed(recording, dict.fromkeys((*ANGLES, "torque"), signs))
    signals = dict(turned.signals)
    for name in ("position", "link_position", "command"):
        if name in signals:
            signals[name] = Signal(signals[name].time, signals[name].values + zeros)
    return replace(turned, signals=signals)


def _changed(recording: Recording, factors: dict[str, np.ndarray]) -> Recording:
    """Signals times a factor a joint (n,), or a matrix (n, n) from the left."""
    signals = dict(recording.signals)
    for name, factor in factors.items():
        if name in signals:
            old = signals[name]
            # A diagonal matrix must not spread the NaN of one joint to all.
            diagonal = factor if factor.ndim == 1 else np.diag(factor)
            plain = factor.ndim == 1 or np.array_equal(factor, np.diag(diagonal))
            with np.errstate(over="ignore", invalid="ignore"):  # what is no number is found by the checks
                values = old.values * diagonal if plain else old.values @ factor.T
            signals[name] = Signal(old.time, values)
    return replace(recording, signals=signals)
