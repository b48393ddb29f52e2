"""A mistake that a log may have: facts about the log, and the corrections to be tried."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from .change import Change, scaled
from .samples import Sampled
from .units import encoder_odds, motion_odds


@dataclass(frozen=True)
class Case:
    """One mistake of a kind."""

    clause: str  # clause on what is wrong
    change: Change  # correction of the log
    joints: tuple[int, ...]  # indices of the joints that show it
    cure: str = ""  # instruction for this case in place of that of its kind


@dataclass(frozen=True)
class LogFacts:
    """Facts about one log."""

    robot: Robot  # described arm
    log: Sampled  # the log as it is read
    # Gain of each drive, from masses and friction, over the stated gain, shape (n,); NaN if either is
    # unknown.
    ratio: np.ndarray
    torques: bool  # whether the log has torques rather than currents
    servo: bool = False  # whether the efforts are errors of position servos
    # Encoder resolution of each joint in the unit of the log, shape (n,); NaN if none is visible.
    steps: np.ndarray | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return self.robot.joints

    @property
    def gain(self) -> np.ndarray:
        """Gains with which efforts became torques, shape (n,)."""
        return np.ones(self.robot.dof) if self.torques else self.robot.drive_gain

    @property
    def moving(self) -> list[int]:
        """Indices of the joints that move; the others carry no information."""
        return np.flatnonzero(self.log.moving).tolist()

    @property
    def turning(self) -> list[int]:
        """Indices of the revolute joints that move."""
        return [joint for joint in self.moving if self.robot.revolute[joint]]

    def of_all(self, clause: str, change: Change) -> Case:
        """Case that all moving joints show."""
        return Case(clause, change, tuple(self.moving))

    def where(self, joints: Mapping[int, float]) -> np.ndarray:
        """Matrix of factors of some joints, and 1 for the others, shape (n, n)."""
        values = np.ones(self.robot.dof)
        values[list(joints)] = list(joints.values())
        return scaled(values)

    def usual(self, change: Change) -> float:
        """Log odds of speeds, ranges and encoder steps after a change, relative to those in the log."""
        if change.position is None:
            return 0.0
        odds = self._moves(change.log(self.log)) - self._moves(self.log)
        if self.steps is not None:
            turning = self.robot.revolute
            scale = np.abs(np.diag(change.position))
            plain = encoder_odds(self.steps[turning], np.ones(int(turning.sum())))
            odds += encoder_odds(self.steps[turning], scale[turning]) - plain
        return odds

    def _moves(self, log: Sampled) -> float:
        speed = np.percentile(np.abs(log.motion.velocity), 99.5, axis=0)
        return motion_odds(speed, np.ptp(log.motion.position, axis=0), self.robot)


@dataclass(frozen=True)
class Mistake:
    """A kind of mistake."""

    name: str  # identifier
    prior: float  # probability that a log has the mistake
    cure: str  # instruction for its correction
    cases: Callable[[LogFacts], Iterator[Case]]  # function that yields the cases of the mistake for a log
    # Whether it differs from another one only in size or sign of efforts, so that their unit must be known.
    of_sizes: bool = False
