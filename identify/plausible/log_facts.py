"""What is known about one log, and a kind of mistake that it may have."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from .changes import Change
from .samples import Sampled
from .units import encoder_odds, motion_odds


@dataclass(frozen=True)
class LogFacts:
    """What is known about one log.

    Attributes:
        robot: The arm as described.
        log: Its log, as it is read.
        ratio: Gain of each drive, from masses and friction, over the one stated, shape (n,); NaN where it is
            unknown or none is stated.
        constants: Drive gains of the description [N m per unit], shape (n,).
        torques: Whether the log has torques rather than currents.
        servo: Whether the efforts are errors of position servos.
        steps: Step of each joint's encoder, as the log states positions; NaN where none is seen, shape (n,).
    """

    robot: Robot
    log: Sampled
    ratio: np.ndarray
    constants: np.ndarray
    torques: bool
    servo: bool = False
    steps: np.ndarray | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return self.robot.joints

    @property
    def moving(self) -> list[int]:
        """Joints that move: the others show nothing."""
        return np.flatnonzero(self.log.moving).tolist()

    def where(self, joints: Mapping[int, float] | int, usual: float = 1.0) -> np.ndarray:
        """A number for some joints, and `usual` for the others, shape (n,)."""
        values = np.full(self.robot.dof, usual)
        for joint, value in joints.items() if isinstance(joints, Mapping) else ((joints, -1.0),):
            values[joint] = value
        return values

    def usual(self, change: Change) -> float:
        """Log odds of speeds, ranges and encoders without a mistake, over those that were logged."""
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


Case = tuple[str, Change, tuple[int, ...]]
"""What is wrong, in a clause; what makes the log right; the joints that show it."""


@dataclass(frozen=True)
class Mistake:
    """A kind of mistake.

    Attributes:
        name: Identifier.
        prior: Probability that a log has it.
        cure: What to do about it.
        cases: Yields the cases of the mistake that a log may have.
        of_sign: Whether signs show it: sizes rest on the described masses, which nobody may have measured.
        always: Whether it is weighed even where bodies explain the log: bodies of any mass may hide it.
    """

    name: str
    prior: float
    cure: str
    cases: Callable[[LogFacts], Iterator[Case]]
    of_sign: bool = False
    always: bool = False
