"""Columns of joints, and the same seen from the motors, which differ where a motor turns with several."""

import numpy as np

from ....arm.robot import Robot
from ....errors import NotRecorded
from ...runs.driven import Driven


def coupled(robot: Robot) -> bool:
    """Whether a motor turns with several joints."""
    return not np.array_equal(robot.to_motors, np.eye(robot.dof))


def on_motors(robot: Robot, columns: np.ndarray) -> np.ndarray:
    """Columns (t, n, p) of joint torque as those of motor torque."""
    return np.einsum("ij,tjp->tip", robot.to_motors, columns) if coupled(robot) else columns


def on_joint(run: Driven, joint: int, torque: np.ndarray) -> np.ndarray:
    """Columns (t, n, p) that act on one joint, of its torque (t,) or (t, p) [N m]."""
    own = torque[:, None] if torque.ndim == 1 else torque
    columns = np.zeros((*run.torque.shape, own.shape[1]))
    columns[:, joint] = own
    return columns


def require_current(run: Driven) -> None:
    """Raise where torque was recorded, which has no gain.

    Raises:
        NotRecorded: It was.
    """
    if run.prepared.measures != "current":
        raise NotRecorded("current was not recorded")
