"""Gravity along any axis of the base."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ....model import Model
from ...runs.driven import Driven
from .motors import on_motors


def gravity_columns(model: Model, run: Driven, axes: Sequence[int]) -> np.ndarray:
    """Torque of the motors by gravity along some axes of the base, shape (t, n, a) [N m]."""
    return on_motors(model.robot, np.stack([_gravity(model, run, axis) for axis in axes], axis=2))


def _gravity(model: Model, run: Driven, axis: int) -> np.ndarray:
    """Torque of gravity along an axis of the base, shape (t, n) [N m]; payloads included."""
    kinematics = run.bodies.copy()
    field = np.zeros(3)
    field[axis] = np.linalg.norm(model.robot.kinematics.gravity.linear)
    kinematics.gravity = pin.Motion(field, np.zeros(3))
    data = kinematics.createData()
    return np.array([pin.computeGeneralizedGravity(kinematics, data, q) for q in run.motion.position])
