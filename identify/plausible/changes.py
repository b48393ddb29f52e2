"""What a mistake does to a log, undone: another order, scale, zero, sign, or another direction of gravity."""

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from ..arm.motion import Motion
from ..model import Model
from .evidence import Reading
from .samples import Sampled


@dataclass(frozen=True)
class Change:
    """What makes a log right.

    Attributes:
        position: Column of each joint's position, shape (n,); None where they are in order.
        effort: The same of the efforts.
        scale: Factor of each position, and of its motion, after that, shape (n,).
        zero: What is added to it then [rad, m].
        factor: Factor of each effort, with its sign, shape (n,); NaN where it may be any of either sign.
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
        """Whether it changes the sizes and signs of efforts alone."""
        parts = (self.position, self.effort, self.scale, self.zero, self.gravity)
        return all(part is None for part in parts)

    @property
    def of_motion(self) -> bool:
        """Whether it changes positions or orders."""
        return not self.of_efforts and self.gravity is None

    @property
    def motion(self) -> "Change":
        """What it does to the motion and to the arm alone."""
        return replace(self, effort=None, factor=None)

    def read(self, reading: Reading) -> Reading:
        """The log without the mistake, but for the factors of efforts."""
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
    """The model with another gravity in its base frame, shape (3,) [m/s^2]."""
    kinematics = model.robot.kinematics.copy()
    kinematics.gravity = pin.Motion(np.asarray(gravity, float), np.zeros(3))
    return replace(model, robot=replace(model.robot, kinematics=kinematics))
