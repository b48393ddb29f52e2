"""Facts about one log, and the definition of a mistake that it may have."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from .changes import Change
from .samples import Sampled
from .units import encoder_odds, motion_odds


@dataclass(frozen=True)
class LogFacts:
    """Facts about one log.

    Attributes:
        robot: Described arm.
        log: Log without a correction.
        ratio: Gain of each drive, from masses and friction, over the stated gain, shape (n,); NaN if either
            is unknown.
        constants: Drive gains of the description, shape (n,) [N m per unit].
        torques: Whether the log has torques rather than currents.
        servo: Whether the efforts are errors of position servos.
        steps: Encoder resolution of each joint in the unit of the log, shape (n,); NaN if none is visible.
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
        """Indices of the joints that move; the others carry no information."""
        return np.flatnonzero(self.log.moving).tolist()

    def where(self, joints: Mapping[int, float] | int, usual: float = 1.0) -> np.ndarray:
        """Given numbers for some joints, and `usual` for the others, shape (n,)."""
        values = np.full(self.robot.dof, usual)
        for joint, value in joints.items() if isinstance(joints, Mapping) else ((joints, -1.0),):
            values[joint] = value
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


Case = tuple[str, Change, tuple[int, ...]]
"""Clause on what is wrong; change that corrects the log; joints that show it."""


@dataclass(frozen=True)
class Mistake:
    """A kind of mistake.

    Attributes:
        name: Identifier.
        prior: Probability that a log has the mistake.
        cure: Instruction for its correction.
        cases: Function that yields the cases of the mistake for a log.
        of_sign: Whether signs show it; sizes depend on the described masses, which may not be measured.
        always: Whether it is tested even if bodies explain the log, because bodies of any mass can hide it.
    """

    name: str
    prior: float
    cure: str
    cases: Callable[[LogFacts], Iterator[Case]]
    of_sign: bool = False
    always: bool = False
