"""Corrections of mistakes in a log: order, scale, zero and sign of columns, and direction of gravity."""

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from ..arm.motion import Motion
from ..model import Model
from .evidence import Reading
from .samples import Sampled


@dataclass(frozen=True)
class Change:
    """Correction of a mistake in a log, applied in the order of the attributes.

    Attributes:
        position: Column of each joint's position, shape (n,); None if the columns are in order.
        effort: Column of each joint's effort, shape (n,); None if the columns are in order.
        scale: Factor of each position and its derivatives, shape (n,).
        zero: Offset added to each scaled position, shape (n,) [rad, m].
        factor: Factor of each effort, with its sign, shape (n,); NaN for any factor of either sign.
        gravity: Gravity in the base frame, shape (3,) [m/s^2].
    """

    position: np.ndarray | None = None
    effort: np.ndarray | None = None
    scale: np.ndarray | None = None
    zero: np.ndarray | None = None
    factor: np.ndarray | None = None
    gravity: np.ndarray | None = None

    @property
    def of_efforts(self) -> bool:
        """Whether only sizes and signs of efforts change."""
        parts = (self.position, self.effort, self.scale, self.zero, self.gravity)
        return all(part is None for part in parts)

    @property
    def of_motion(self) -> bool:
        """Whether positions or the order of columns change."""
        return not self.of_efforts and self.gravity is None

    @property
    def motion(self) -> "Change":
        """The part of the change that concerns motion and arm, not efforts."""
        return replace(self, effort=None, factor=None)

    def read(self, reading: Reading) -> Reading:
        """The log with the correction applied, except for the factors of efforts."""
        if self.of_efforts:
            return reading
        if self.effort is not None:
            return self.motion.read(reading).with_efforts(self.effort)
        model = reading.model if self.gravity is None else with_gravity(reading.model, self.gravity)
        return Reading(model, self._moved(reading.log), reading.stated)

    def _moved(self, log: Sampled) -> Sampled:
        columns = np.arange(log.effort.shape[1])
        position = columns if self.position is None else self.position
        scale = 1.0 if self.scale is None else self.scale
        zero = 0.0 if self.zero is None else self.zero
        old = log.motion
        motion = Motion.of(
            old.time,
            old.position[:, position] * scale + zero,
            old.velocity[:, position] * scale,
            old.acceleration[:, position] * scale,
        )
        return Sampled(motion, log.effort, log.sliding[:, position])


def with_gravity(model: Model, gravity: np.ndarray) -> Model:
    """Copy of a model with another gravity in its base frame, shape (3,) [m/s^2]."""
    kinematics = model.robot.kinematics.copy()
    kinematics.gravity = pin.Motion(np.asarray(gravity, float), np.zeros(3))
    return replace(model, robot=replace(model.robot, kinematics=kinematics))
