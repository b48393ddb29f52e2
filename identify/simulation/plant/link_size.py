"""Typical inertia and load of each joint, which determine the size of its gear."""

import numpy as np
import pinocchio as pin

from ...model import Model

POSES = 64
"""Number of random poses over which inertia and load are averaged."""


def random_poses(model: Model) -> np.ndarray:
    """Random poses within the joint range, shape (POSES, n) [rad]."""
    limits = model.robot.limits
    lower, upper = np.maximum(limits.position_lower, -np.pi), np.minimum(limits.position_upper, np.pi)
    return np.random.default_rng(0).uniform(lower, upper, (POSES, model.robot.dof))


def link_size(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Inertia [kg m^2] and load by gravity and 1 rad/s^2 [N m] of each joint, means over poses, each (n,)."""
    kinematics, _ = model.bodies_apart(model.nominal_values, "")
    data, poses = kinematics.createData(), random_poses(model)
    inertia = np.mean([np.diagonal(pin.crba(kinematics, data, pose)) for pose in poses], axis=0)
    weights = [pin.computeGeneralizedGravity(kinematics, data, pose) for pose in poses]
    return inertia, np.mean(np.abs(weights), axis=0) + inertia
