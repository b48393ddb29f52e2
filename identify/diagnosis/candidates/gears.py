"""Torque of a gear that bends under load."""

import numpy as np

from ...measurements.twist import bent
from ...model import Model
from ..runs.driven import Driven


def bending(model: Model, run: Driven, joint: int, gear: tuple[float, float]) -> np.ndarray:
    """Motor torque beyond that of a rigid gear, shape (t, n) [N m].

    Args:
        model: Model of the arm.
        run: Run.
        joint: Joint with the gear, from 0.
        gear: Stiffness [N m/rad] and damping [N m s/rad].
    """
    weight, drag, inertia = run.tangent.own(joint)
    step = float(np.median(np.diff(run.motion.time)))
    twist = bent(inertia, gear[1] + drag, gear[0] + weight, run.motion.load[:, joint], step)
    return -run.tangent.torque(joint, *twist) @ model.robot.to_motors.T
