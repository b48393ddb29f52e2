"""What a feedforward amounts to on each joint."""

from typing import NamedTuple

import numpy as np

from ..fit.base_parameters import rich_motion
from ..model import Model
from .feedforward import Feedforward

REFERENCE = 25.0
"""Temperature at which friction that depends on it is summarized [degC]."""

ROUNDING = 1e-12
"""Share of the largest torque below which a torque is a rounding error, as that of a vertical axis."""


class Summary(NamedTuple):
    """Torques of each joint, each of shape (n,)."""

    gravity: np.ndarray  # largest holding torque over poses within the position limits [N m]
    friction: np.ndarray  # friction at twice the band of velocity, at rest of the other joints [N m]
    compensated: np.ndarray  # part of that friction that is compensated [N m]
    # Largest position offset of the servos over the same poses [rad]; None without servos.
    offset: np.ndarray | None


def summary(feedforward: Feedforward) -> Summary:
    """Summary over random poses within the position limits."""
    poses = rich_motion(Model(feedforward.robot, ())).position
    warm = np.full_like(poses, REFERENCE)
    speed = np.broadcast_to(2.0 * feedforward.band, poses.shape)
    gravity = np.abs(feedforward.gravity(poses, warm)).max(axis=0)
    gravity = np.where(gravity > ROUNDING * gravity.max(), gravity, 0.0)
    friction = np.abs(feedforward.friction(poses, speed, warm)).max(axis=0)
    compensated = np.abs(feedforward.friction_compensation(poses, speed, warm)).max(axis=0)
    offset = None
    if feedforward.servo is not None:
        offset = np.abs(feedforward.position_offset(poses, warm)).max(axis=0)
    return Summary(gravity, friction, compensated, offset)
