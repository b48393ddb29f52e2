"""Player: the sequence of commands of an approach, a motion and stops."""

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
"""Commanded step per cycle below which the arm counts as at rest [rad]: the rounding error of a stop."""


class _Part(NamedTuple):
    """A sequence of states to command, and its stage."""

    stage: int
    states: States


class Player:
    """Generates one command per cycle: the approach, the motion, and rest at its end.

    Each command advances the motion by one cycle, whatever time has passed: a late cycle delays the motion
    instead of making it jump.

    Args:
        motion: Motion to play; it may start and end in motion.
        limits: Limits of the approach and of stops, finite in velocity, acceleration and jerk.
        cycle: Time between commands [s].
        settle: Duration of commanded, and recorded, rest after the motion or a stop [s].
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
        """Whether rest has been commanded for the settling time."""
        return self._rested >= self._settle

    def approach(self, measured: np.ndarray, limits: Limits | None = None) -> Phases:
        """The trajectory from rest at a position (n,) [rad] to the motion, by its own or other limits.

        Raises:
            TrajectoryError: If there is none within the position limits.
        """
        return lead_in(State.at_rest(measured), self.motion, limits or self._limits, self.cycle)

    def begin(self, approach: Trajectory) -> None:
        """Start the approach, followed by the motion, with the next command."""
        states = approach.every(self.cycle)
        without_last = States(*(column[:-1] for column in states))  # the last is the first of the motion
        self._parts = [_Part(APPROACHING, without_last), _Part(RUNNING, self._states)]
        self._row = -1

    def next(self) -> Command | None:
        """Command of the next cycle; None before the approach has begun."""
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
            self._command_rest()
        assert self._last is not None
        return Command(self._last.position, self._last.velocity)

    def brake(self) -> None:
        """Stop each joint as fast as its limits allow, starting with the next command."""
        self._parts, self._row = [], 0
        if self._last is None:  # nothing has been commanded, so nothing moves
            self._rested = self._settle
        elif not self._at_rest:
            stop = brake(self._last, self._limits, self.cycle)
            self._parts = [_Part(BRAKING, stop.every(self.cycle))]

    def take_back(self) -> None:
        """Undo the last command, which was not sent."""
        self._last = self._before

    @property
    def _at_rest(self) -> bool:
        if self._last is None:
            return True
        step = np.abs(self._last.velocity) * self.cycle + np.abs(self._last.acceleration) * self.cycle**2
        return bool(step.max() < STILL)

    def _command_rest(self) -> None:
        assert self._last is not None
        self.stage = HOLDING
        self._rested += 1
        self._last = State.at_rest(self._last.position)
