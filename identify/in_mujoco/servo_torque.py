"""Torque of logs of commands and positions alone: what the servos of the simulation's file give for those.

A position servo of MuJoCo's gives kp (command - position) - kv velocity, within its range of force. The
velocity is that of the end of a step where the integrator is implicit, of its beginning under Euler: half
a step after or before the one that positions show. So kv adds kv step / 2 to a joint's inertia in the
simulation, or takes that away: of a UR10e's file with kv 500 and steps of 2 ms 0.5 kg m^2, five times its
armature. Taken as it acts there, what is fitted is the inertia with which the simulation moves as the arm
does.
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
    model: Any, recording: Recording, joints: Sequence[str], ahead: float | None = None
) -> Recording:
    """A recording with the torque of the file's servos in place of their error; another as it is.

    So is one whose robot states the law of its servos: there their kp is a drive gain, which is fitted.

    Args:
        model: What MuJoCo makes of the file.
        recording: With the error of servos, or a measured effort.
        joints: Names.
        ahead: Time by which the velocity that the servos' damping takes is ahead of the positions' [s]; that
            of the file's integrator by default.

    Raises:
        RecordingError: The file has no position servo for every joint.
    """
    if recording.robot.servo is not None or not is_servo_error(recording.settings):
        return recording
    actuators = servos(model, joints)
    if not actuators:
        raise RecordingError(
            f"{recording.name} has no effort but the error of its servos, and the file no position servo for "
            "every joint, whose torque that would be"
        )
    kept = {name: signal for name, signal in recording.signals.items() if name not in EFFORT}
    error, position = recording.signals["current"], recording.signals["position"]
    # Differences of encoder steps: the filter of torques smooths them.
    velocity = np.gradient(position.values, position.time, axis=0)
    ahead = lead(model) if ahead is None else ahead
    velocity = velocity + ahead * np.gradient(velocity, position.time, axis=0)
    torque = servo_torque(model, actuators, error.values, velocity)
    with_torque = replace(recording, signals=kept | {"torque": Signal(position.time, torque)})
    return with_torque.with_warnings(*_clipped(model, actuators, joints, torque))


def _clipped(
    model: Any, actuators: Sequence[int], joints: Sequence[str], torque: np.ndarray
) -> Iterator[str]:
    """Warnings about joints whose torque, shape (t, n), is at the limit of the file's servo."""
    for joint, actuator, column in zip(joints, actuators, torque.T, strict=True):
        if not model.actuator_forcelimited[actuator]:
            continue
        gear, ends = model.actuator_gear[actuator, 0], model.actuator_forcerange[actuator]
        clipped = int(np.sum(np.isin(column, gear * ends)))
        if clipped > max(FEW, SELDOM * len(column)):
            kp, most = -model.actuator_biasprm[actuator, 1], float(np.abs(ends).max())
            yield (
                f"torque: the servo of {joint} is at its limit (forcerange {most:g}) in {clipped} of "
                f"{len(column)} samples: with kp = {kp:g} in the file, that is {most / kp / gear:.2g} rad "
                "from the command. If kp is wrong, exidyn init LOG --mjcf FILE estimates it"
            )


def lead(model: Any) -> float:
    """Time by which the velocity that a servo's damping takes is ahead of the positions' [s].

    Under RK4 it is that of the moment; but the command is held over a step, which adds the same inertia.
    """
    late = model.opt.integrator == enum_of("mjtIntegrator", "mjINT_EULER")
    return (-0.5 if late else 0.5) * float(model.opt.timestep)


def servo_torque(model: Any, actuators: Sequence[int], error: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Torque of the joints by the errors (t, n) [rad] and velocities (t, n) [rad/s], shape (t, n) [N m]."""
    gear, numbers = model.actuator_gear[actuators, 0], model.actuator_biasprm[actuators]
    force = gear * (numbers[:, 2] * velocity - numbers[:, 1] * error)
    limited, ends = model.actuator_forcelimited[actuators] > 0, model.actuator_forcerange[actuators]
    ends = np.where(limited[:, None], ends, [-np.inf, np.inf])
    return np.asarray(gear * np.clip(force, ends[:, 0], ends[:, 1]))
