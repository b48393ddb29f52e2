"""Floating: the arm held by a model's torque alone, with the drives' position control off.

The arm is held in position control first, while the torque fades in, so that compliant drives do not jump.
While it floats, each command states where the arm is: a stop holds it there, or brakes it from there, with
position control and the torque of that position.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from exidyn.drivers import Command, Sample
from exidyn.drivers.values import any_of
from exidyn.identification.arm.robot import Limits
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.trajectory import State, Trajectory, whole_ticks

from .player import RUNNING, Player
from .stopping.stop import Stop
from .stopping.watch import CommandCheck

FADE_IN = 2.0
"""Time in which the torque fades in before the arm floats [s]."""
SPEED_TIME = 0.02
"""Time over which velocity is measured from positions [s], as that of the monitor of speeds."""

Torque = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Joint torque (n,) [N m] that holds an arm with a position (n,) [rad] and a velocity (n,) [rad/s]."""


def floating_motion(position: np.ndarray, seconds: float, cycle: float) -> Phases:
    """Rest at a position (n,) [rad] while the torque fades in, and for the time to float [s]."""
    return Phases.hold(position, whole_ticks(FADE_IN + seconds, cycle))


class FloatingPlayer(Player):
    """Commands that let the arm float during a `floating_motion`.

    Args:
        motion: Motion of `floating_motion`.
        limits: Limits of the stop at the end, finite in velocity, acceleration and jerk.
        cycle: Time between commands [s].
        settle: Duration of commanded rest at the end [s].
        torque: Torque that holds the arm.
        last_sample: Function that returns the last sample.
    """

    def __init__(
        self,
        motion: Trajectory,
        limits: Limits,
        cycle: float,
        settle: float,
        torque: Torque,
        last_sample: Callable[[], Sample | None],
    ) -> None:
        super().__init__(motion, limits, cycle, settle)
        start = motion.state_at(0.0).position
        self._torque, self._last_sample = torque, last_sample
        self._fading, self._faded = max(round(FADE_IN / cycle), 1), 0
        self._still = np.zeros(len(start))
        self._positions = deque([start], maxlen=max(round(SPEED_TIME / cycle), 2) + 1)

    def next(self) -> Command | None:
        """Command of the next cycle; None before the arm is commanded."""
        command = super().next()
        if command is None:
            return None
        if self.stage == RUNNING and self._faded >= self._fading:
            return self._float()
        self._faded += self.stage == RUNNING
        s = min(self._faded / self._fading, 1.0)
        return replace(command, torque=s * s * (3.0 - 2.0 * s) * self._torque(command.position, self._still))

    def _float(self) -> Command:
        """The command for where the arm is; silent joints keep their last position."""
        sample, before = self._last_sample(), self._positions[-1]
        measured = before if sample is None else sample.position
        position = np.where(np.isfinite(measured), measured, before)
        self._positions.append(position)
        velocity = (position - self._positions[0]) / (self.cycle * (len(self._positions) - 1))
        self._last = State(position, velocity, self._still)
        return Command(position, velocity, self._torque(position, velocity), floats=True)


class FloatingCheck(CommandCheck):
    """Checks the torque of each command, and that an arm that floats is within its limits."""

    def look(self, command: Command) -> Stop | None:
        """The reason not to send a command; None if it is valid."""
        torque, most = command.torque, self._robot.limits.torque
        if torque is None or not np.isfinite(torque).all():
            return self._stop("command torque", 0, float("nan"), 0.0, "N m", "is not a number")
        if any_of(beyond := np.abs(torque) > most):
            j = int(np.argmax(beyond))
            return self._stop("command torque", j, torque[j], most[j], "N m", "exceeds the limit of")
        return self._float(command) if command.floats else super().look(command)

    def _float(self, command: Command) -> Stop | None:
        """A floating arm goes where it is pushed; the stop begins where it is, at its speed."""
        stop = self._outside(command.position)
        if stop is None:
            self._before, self._step_before = command.position, self._cycle * command.velocity
        return stop
