"""A mistake that a log may have: facts about the log, and the change that corrects the mistake.

A change corrects order, scale, zero and sign of columns, and the direction of gravity.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from ..arm.motion import Motion
from ..arm.robot import Robot
from ..model import Model
from .evidence import Reading
from .samples import Sampled
from .units import encoder_odds, motion_odds


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


Case = tuple[str, Change, tuple[int, ...]]
"""Clause on what is wrong; change that corrects the log; joints that show it."""


@dataclass(frozen=True)
class LogFacts:
    """Facts about one log."""

    robot: Robot  # described arm
    log: Sampled  # log without a correction
    # Gain of each drive, from masses and friction, over the stated gain, shape (n,); NaN if either is
    # unknown.
    ratio: np.ndarray
    constants: np.ndarray  # drive gains of the description, shape (n,) [N m per unit]
    torques: bool  # whether the log has torques rather than currents
    servo: bool = False  # whether the efforts are errors of position servos
    # Encoder resolution of each joint in the unit of the log, shape (n,); NaN if none is visible.
    steps: np.ndarray | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return self.robot.joints

    @property
    def moving(self) -> list[int]:
        """Indices of the joints that move; the others carry no information."""
        return np.flatnonzero(self.log.moving).tolist()

    def of_all(self, clause: str, change: Change) -> Case:
        """Case that all moving joints show."""
        return clause, change, tuple(self.moving)

    def where(self, joints: Mapping[int, float]) -> np.ndarray:
        """Numbers of some joints, and 1 for the others, shape (n,)."""
        values = np.ones(self.robot.dof)
        values[list(joints)] = list(joints.values())
        return values

    def usual(self, change: Change) -> float:
        """Log odds of speeds, ranges and encoder steps after a change, relative to those in the log."""
        if change.scale is None:
            return 0.0
        speed = np.percentile(np.abs(self.log.motion.velocity), 99.5, axis=0)
        reach = np.ptp(self.log.motion.position, axis=0)
        scales = np.abs(change.scale)
        odds = motion_odds(speed * scales, reach * scales, self.robot) - motion_odds(speed, reach, self.robot)
        if self.steps is not None:
            turning = self.robot.revolute
            plain = encoder_odds(self.steps[turning], np.ones(int(turning.sum())))
            odds += encoder_odds(self.steps[turning], scales[turning]) - plain
        return odds


@dataclass(frozen=True)
class Mistake:
    """A kind of mistake."""

    name: str  # identifier
    prior: float  # probability that a log has the mistake
    cure: str  # instruction for its correction
    cases: Callable[[LogFacts], Iterator[Case]]  # function that yields the cases of the mistake for a log
    # Whether signs show it; sizes depend on the described masses, which may not be measured.
    of_sign: bool = False
    # Whether it is tested even if bodies explain the log, because bodies of any mass can hide it.
    always: bool = False
