"""Torque of a gear that gives way, as a diagnosis asks about it."""

import numpy as np

from ...measurements.twist import bent
from ...model import Model
from ..runs.driven import Driven


def bending(model: Model, run: Driven, joint: int, gear: tuple[float, float]) -> np.ndarray:
    """Torque of the motors beyond that of a rigid gear, (t, n) [N m].

    Of one joint's gear: its stiffness [N m/rad] and damping [N m s/rad].
    """
    weight, drag, inertia = run.tangent.own(joint)
    step = float(np.median(np.diff(run.motion.time)))
    twist = bent(inertia, gear[1] + drag, gear[0] + weight, run.motion.load[:, joint], step)
    return -run.tangent.torque(joint, *twist) @ model.robot.to_motors.T
