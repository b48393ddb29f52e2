"""Player: what to command next, from where the arm stands to the end of the motion, and how to stop."""

from typing import NamedTuple

import numpy as np

from exidyn.drivers import Command
from exidyn.identification.arm.robot import Limits
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.limits.leads import lead_in
from exidyn.trajectories.limits.moves import brake
from exidyn.trajectories.trajectory import State, States, Trajectory

from .frames import STAGES

LISTENING, APPROACHING, RUNNING, BRAKING, HOLDING = range(len(STAGES))
STILL = 1e-9
"""Step a cycle below which the arm is commanded to rest [rad]: rounding of a stop's last piece."""


class _Part(NamedTuple):
    """States that are commanded one after another, and what that is called."""

    stage: int
    states: States


class Player:
    """Gives one command a cycle: the way to the motion, the motion, and rest where it ends.

    The motion's time goes on by one cycle a command, whatever time has gone by: a late cycle delays the
    rest instead of making it jump.

    Args:
        motion: What to play; it may begin and end moving.
        limits: Finite velocity, acceleration and jerk: of the approach and of stops.
        cycle: Time between commands [s].
        settle: How long rest is commanded, and so recorded, after the motion or a stop [s].
    """

    def __init__(self, motion: Trajectory, limits: Limits, cycle: float, settle: float = 0.5) -> None:
        self.motion, self.cycle = motion, cycle
        self._limits = limits
        self._settle = max(round(settle / cycle), 1)
        self._states = motion.every(cycle)
        self._parts: list[_Part] = []
        self._row = 0
        self._rested = 0
        self._last: State | None = None
        self._before: State | None = None
        self.stage = LISTENING

    @property
    def finished(self) -> bool:
        """Whether the arm has been commanded to rest for as long as it should settle."""
        return self._rested >= self._settle

    def approach(self, measured: np.ndarray, limits: Limits | None = None) -> Phases:
        """The way from rest at a measured position to where the motion begins.

        Args:
            measured: Shape (n,) [rad].
            limits: Other than those of the player.

        Raises:
            TrajectoryError: There is none within the position limits.
        """
        return lead_in(State.at_rest(measured), self.motion, limits or self._limits, self.cycle)

    def begin(self, approach: Trajectory) -> None:
        """From the next command on, approach and then play the motion."""
        way = approach.every(self.cycle)
        without_last = States(*(column[:-1] for column in way))  # which is the first of the motion
        self._parts = [_Part(APPROACHING, without_last), _Part(RUNNING, self._states)]
        self._row = -1

    def next(self) -> Command | None:
        """What to command in the coming cycle; None before it has begun."""
        if not self._parts and self._last is None:
            return None
        self._row += 1
        while self._parts and self._row >= len(self._parts[0].states.time):
            self._parts, self._row = self._parts[1:], 0
        if not self._parts and not self._at_rest:
            self.brake()
            self._row = 1
        self._before = self._last
        if self._parts:
            self.stage, states = self._parts[0]
            self._last = states.state(min(self._row, len(states.time) - 1))
        else:
            self._rest()
        assert self._last is not None
        return Command(self._last.position, self._last.velocity)

    def brake(self) -> None:
        """From the next command on, stop each joint as fast as its limits allow."""
        self._parts, self._row = [], 0
        if self._last is None:  # nothing has been commanded, so nothing moves
            self._rested = self._settle
        elif not self._at_rest:
            stop = brake(self._last, self._limits, self.cycle)
            self._parts = [_Part(BRAKING, stop.every(self.cycle))]

    def take_back(self) -> None:
        """The last command was not sent."""
        self._last = self._before

    @property
    def _at_rest(self) -> bool:
        if self._last is None:
            return True
        step = np.abs(self._last.velocity) * self.cycle + np.abs(self._last.acceleration) * self.cycle**2
        return bool(step.max() < STILL)

    def _rest(self) -> None:
        assert self._last is not None
        self.stage = HOLDING
        self._rested += 1
        self._last = State.at_rest(self._last.position)
