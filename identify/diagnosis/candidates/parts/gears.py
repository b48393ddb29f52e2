"""Gears that give way: the twist between motor and link, and what motors give for it.

With motors where their encoders measure, every link but one follows its motor, and that one leads or lags
by a twist whose equation is row j of the arm's: M_jj twist'' + d twist' + (K + dtau_j/dq_j) twist = load_j.
What all motors give for it more than for a rigid gear is minus the links' torque for a twist.
"""

import numpy as np
import pinocchio as pin

from ....model import Model
from ....simulation.plant.bodies_apart import bodies_apart
from ...runs.driven import Driven
from ...runs.gear_twist import bent

POSES = 64
"""Over which the inertia of a link is averaged."""


def bending(model: Model, run: Driven, joint: int, gear: tuple[float, float]) -> np.ndarray:
    """Torque of the motors beyond that of a rigid gear, shape (t, n) [N m].

    Args:
        model: For which joints motors turn.
        run: The motion, and the load.
        joint: The elastic one.
        gear: Its stiffness [N m/rad] and damping [N m s/rad].
    """
    weight, drag, inertia = run.tangent.own(joint)
    step = float(np.median(np.diff(run.motion.time)))
    twist = bent(inertia, gear[1] + drag, gear[0] + weight, run.motion.load[:, joint], step)
    return -run.tangent.torque(joint, *twist) @ model.robot.to_motors.T


def link_size(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Inertia [kg m^2] and load [N m] of each joint, its rotor apart, means over poses, each (n,).

    The load is that of gravity and of 1 rad/s^2.
    """
    kinematics, _ = bodies_apart(model, model.nominal_values, "")
    data, limits = kinematics.createData(), model.robot.limits
    lower, upper = np.maximum(limits.position_lower, -np.pi), np.minimum(limits.position_upper, np.pi)
    poses = np.random.default_rng(0).uniform(lower, upper, (POSES, model.robot.dof))
    inertia = np.mean([np.diagonal(pin.crba(kinematics, data, pose)) for pose in poses], axis=0)
    weights = [pin.computeGeneralizedGravity(kinematics, data, pose) for pose in poses]
    return inertia, np.mean(np.abs(weights), axis=0) + inertia
