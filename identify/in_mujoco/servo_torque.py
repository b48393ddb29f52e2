"""Torque of logs that have commands and positions alone: what the servos of the simulation's file give for those.

A position servo of MuJoCo's gives kp (command - position) - kv velocity, within its range of force.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import RecordingError
from ..recordings.recording import EFFORT, Recording, Signal
from ..recordings.servo_error import is_servo_error
from .replay import servos


def with_servo_torque(model: Any, recording: Recording, joints: Sequence[str]) -> Recording:
    """A recording with the torque of the file's servos in place of their error; another as it is.

    Raises:
        RecordingError: The file has no position servo for every joint.
    """
    if not is_servo_error(recording.settings):
        return recording
    actuators = servos(model, joints)
    if not actuators:
        raise RecordingError(
            f"{recording.name} has no effort but the error of its servos, and the file no position servo for "
            "every joint, whose torque that would be"
        )
    kept = {name: signal for name, signal in recording.signals.items() if name not in EFFORT}
    error, position = recording.signals["current"], recording.signals["position"]
    velocity = np.gradient(position.values, position.time, axis=0)  # the filter of torques smooths it
    torque = servo_torque(model, actuators, error.values, velocity)
    return replace(recording, signals=kept | {"torque": Signal(position.time, torque)})


def servo_torque(model: Any, actuators: Sequence[int], error: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Torque of the joints by the errors (t, n) [rad] and velocities (t, n) [rad/s], shape (t, n) [N m]."""
    gear, numbers = model.actuator_gear[actuators, 0], model.actuator_biasprm[actuators]
    force = gear * (numbers[:, 2] * velocity - numbers[:, 1] * error)
    limited, ends = model.actuator_forcelimited[actuators] > 0, model.actuator_forcerange[actuators]
    ends = np.where(limited[:, None], ends, [-np.inf, np.inf])
    return np.asarray(gear * np.clip(force, ends[:, 0], ends[:, 1]))
