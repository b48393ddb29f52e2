"""The least a regressor can cost from Python: one Pinocchio call a sample, and whole-array friction."""

import numpy as np
import pinocchio as pin

FRICTION_BLOCKS = 4
"""Columns a joint beyond its link's ten: viscous, Coulomb, rotor inertia, offset."""


def regressor_floor(
    kinematics: pin.Model, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
) -> np.ndarray:
    """Regressor of rigid links, viscous and Coulomb friction, rotor inertia and offset.

    Nothing is checked and nothing is named: this is the time that any library pays which asks Pinocchio
    for one sample at a time and keeps what it gets.

    Args:
        kinematics: Arm with one degree of freedom a joint.
        position: Shape (t, n) [rad].
        velocity: Shape (t, n) [rad/s].
        acceleration: Shape (t, n) [rad/s^2].

    Returns:
        Shape (t, n, 14 n) [N m / unit]; links in Pinocchio's order, then one block of n columns each for
        viscous friction, Coulomb friction, rotor inertia and offset.
    """
    samples, joints = position.shape
    rigid = 10 * joints
    out = np.zeros((samples, joints, rigid + FRICTION_BLOCKS * joints))
    data = kinematics.createData()
    for k in range(samples):
        out[k, :, :rigid] = pin.computeJointTorqueRegressor(
            kinematics, data, position[k], velocity[k], acceleration[k]
        )
    joint = np.arange(joints)
    for block, column in enumerate((velocity, np.sign(velocity), acceleration, 1.0)):
        out[:, joint, rigid + block * joints + joint] = column
    return out
