r"""Force on the flange that explains external joint torques, by damped least squares.

With the Jacobian J of the flange, :math:`\tau_{ext} = J^T F`. Each joint is weighted by its standard
deviation without contact, and moments are scaled by a length. Of the singular values
:math:`\sigma_i` of that system, those above a share :math:`\epsilon` of the largest are inverted; the others
become :math:`\sigma_i / \epsilon^2` (numerical filtering; Maciejewski, Klein 1988): near a singular pose, the
force in a direction in which the joints hardly notice it tends to zero instead of infinity, and other
directions keep their force. Arms with fewer than six joints cannot distinguish force from moment; theirs is
a force at the flange without a moment.
"""

import numpy as np
import pinocchio as pin

from ..arm.robot import Robot

LEVER = 0.05
"""Length by which moments are scaled, over the sum of the links' lengths [-]: about that of a tool, 0.1 m on
a UR10e and 0.2 m on an arm that carries 200 kg."""
DAMPED = 0.05
"""Singular value, over the largest, below which a direction is damped [-]."""


def flange_wrenches(robot: Robot, position: np.ndarray, torque: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Force and moment on the flange, in the axes of the base, shape (t, 6) [N, N m].

    Args:
        robot: The arm.
        position: Joint positions, shape (t, n) [rad].
        torque: External joint torques, shape (t, n) [N m]; rows with NaN give NaN.
        scale: Standard deviations of the torques, shape (t, n) [N m].
    """
    data, wrenches = robot.kinematics.createData(), np.full((len(torque), 6), np.nan)
    places = [*robot.kinematics.jointPlacements, robot.flange]
    # Sum of the distances from joint to joint and to the flange [m]; 1 if all of them are zero.
    length = float(sum(np.linalg.norm(place.translation) for place in places)) or 1.0
    lever = LEVER * length
    for row in np.flatnonzero(np.all(np.isfinite(torque) & np.isfinite(scale), axis=1)):
        jacobian = flange_jacobian(robot, data, position[row])
        wrenches[row] = damped_wrench(jacobian, torque[row], scale[row], lever)
    return wrenches


def flange_jacobian(robot: Robot, data: pin.Data, position: np.ndarray) -> np.ndarray:
    """Jacobian of the flange's origin in the axes of the base, linear rows first, shape (6, n)."""
    model, last = robot.kinematics, robot.kinematics.njoints - 1
    pin.computeJointJacobians(model, data, position)
    jacobian = np.asarray(pin.getJointJacobian(model, data, last, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED))
    jacobian = jacobian.reshape(6, model.nv)  # Pinocchio's has one axis for a single joint
    lever = data.oMi[last].rotation @ robot.flange.translation
    moved = jacobian[:3] + np.cross(jacobian[3:].T, lever).T
    return np.concatenate([moved, jacobian[3:]])


def damped_wrench(jacobian: np.ndarray, torque: np.ndarray, scale: np.ndarray, lever: float) -> np.ndarray:
    """Force and moment, shape (6,), that explain external torques (n,) with standard deviations (n,).

    Moments are scaled by `lever` [m].
    """
    parts = 6 if len(torque) >= 6 else 3
    lengths = np.array([1.0, 1.0, 1.0, lever, lever, lever])[:parts]
    rows = jacobian[:parts].T * lengths / scale[:, None]
    rotation, singular, directions = np.linalg.svd(rows, full_matrices=False)
    inverse = singular / np.maximum(np.maximum(singular, DAMPED * singular[0]) ** 2, 1e-300)
    wrench = np.zeros(6)
    wrench[:parts] = directions.T @ (inverse * (rotation.T @ (torque / scale))) * lengths
    return wrench
