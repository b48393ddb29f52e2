"""Columns of joints seen from the motors, which differ where a motor turns with several joints."""

import numpy as np

from ...robot import Robot


def coupled(robot: Robot) -> bool:
    """Whether a motor turns with several joints."""
    return not np.array_equal(robot.to_motors, np.eye(robot.dof))


def on_motors(robot: Robot, columns: np.ndarray) -> np.ndarray:
    """Columns (t, n, p) of joint torque as those of motor torque."""
    return np.einsum("ij,tjp->tip", robot.to_motors, columns) if coupled(robot) else columns
