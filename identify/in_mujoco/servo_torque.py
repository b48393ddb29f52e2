"""Torque for logs that hold only commands and positions, computed from the servos of the simulation's file.

A position servo of MuJoCo exerts kp (command - position) - kv velocity, within its force range. With an
implicit integrator the velocity is the one at the end of a step, with Euler the one at its beginning: half a
step after or before the velocity that positions show. So kv adds kv step / 2 to a joint's inertia in the
simulation, or subtracts it. In a UR10e file with kv 500 and steps of 2 ms that is 0.5 kg m^2, five times the
armature. The same shift is applied here, so the fitted inertia makes the simulation move like the arm.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import RecordingError
from ..recordings.recording import EFFORT, Recording, Signal
from ..recordings.servo_error import FEW, SELDOM, is_servo_error
from ..robot_files.mjcf_drives import servos
from ..robot_files.mjcf_names import enum_of


def with_servo_torque(
    model: Any,
    recording: Recording,
    joints: Sequence[str],
    ahead: float | None = None,
    delay: np.ndarray | None = None,
) -> Recording:
    """The recording, with servo errors replaced by the torque of the file's servos.

    A recording with measured effort is returned unchanged.

    Args:
        model: The compiled MJCF.
        recording: The recording, with servo errors or a measured effort.
        joints: Joint names.
        ahead: Lead of the velocity that the servos' damping uses over the velocity that positions show [s];
            by default, that of the file's integrator.
        delay: Time from a command to its effect on each joint, shape (n,) [s]; zero by default.

    Raises:
        RecordingError: If a joint has no position servo in the file.
    """
    if not is_servo_error(recording.settings):
        return recording
    delay = np.zeros(len(joints)) if delay is None else delay
    actuators = servos(model, joints)
    if not actuators:
        raise RecordingError(
            f"{recording.name} has servo errors but no measured effort, and the file has no position servo "
            "for every joint, so the torque is unknown. State the gains of the controller: --kp KP --kd KD"
        )
    others = {name: signal for name, signal in recording.signals.items() if name not in EFFORT}
    position, command = recording.signals["position"], recording.signals["command"]
    columns = zip(delay, command.values.T, strict=True)
    acting = [np.interp(position.time - later, command.time, column) for later, column in columns]
    error = np.stack(acting, axis=1) - position.values
    # Differences of encoder increments are noisy; the torque filter smooths them.
    velocity = np.gradient(position.values, position.time, axis=0)
    ahead = lead(model) if ahead is None else ahead
    velocity = velocity + ahead * np.gradient(velocity, position.time, axis=0)
    torque = servo_torque(model, actuators, error, velocity)
    with_torque = replace(recording, signals=others | {"torque": Signal(position.time, torque)})
    return with_torque.with_warnings(*_clipped(model, actuators, joints, torque))


def _clipped(
    model: Any, actuators: Sequence[int], joints: Sequence[str], torque: np.ndarray
) -> Iterator[str]:
    """Warnings about joints whose torque, shape (t, n), reaches the limit of the file's servo."""
    for joint, actuator, column in zip(joints, actuators, torque.T, strict=True):
        if not model.actuator_forcelimited[actuator]:
            continue
        gear, ends = model.actuator_gear[actuator, 0], model.actuator_forcerange[actuator]
        clipped = int(np.sum(np.isin(column, gear * ends)))
        if clipped > max(FEW, SELDOM * len(column)):
            kp, limit = -model.actuator_biasprm[actuator, 1], float(np.abs(ends).max())
            yield (
                f"torque: the servo of {joint} is at its limit (forcerange {limit:g}) in {clipped} of "
                f"{len(column)} samples: with kp = {kp:g} in the file, it is reached "
                f"{limit / kp / gear:.2g} rad from the command. If kp is wrong, exidyn init LOG --robot FILE "
                "estimates it"
            )


def lead(model: Any) -> float:
    """Lead of the velocity that a servo's damping uses over the velocity that positions show [s].

    RK4 uses the velocity of the same instant, but holds the command over a step, which adds the same inertia.
    """
    euler = model.opt.integrator == enum_of("mjtIntegrator", "mjINT_EULER")
    return (-0.5 if euler else 0.5) * float(model.opt.timestep)


def servo_torque(model: Any, actuators: Sequence[int], error: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Joint torque at servo errors (t, n) [rad] and velocities (t, n) [rad/s], shape (t, n) [N m]."""
    gear, bias = model.actuator_gear[actuators, 0], model.actuator_biasprm[actuators]
    force = gear * (bias[:, 2] * velocity - bias[:, 1] * error)
    limited, ranges = model.actuator_forcelimited[actuators] > 0, model.actuator_forcerange[actuators]
    ranges = np.where(limited[:, None], ranges, [-np.inf, np.inf])
    return np.asarray(gear * np.clip(force, ranges[:, 0], ranges[:, 1]))
