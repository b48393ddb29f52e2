"""Controller of the mock: how it handles commands, missing commands, and stops by itself."""

import numpy as np

from ..driver import Measured, Plant

LONGEST_IDLE = 2.0
"""Longest time without exchanges that is simulated after the dead-man time [s]; by then all drives stand."""


class MockDrives:
    """Drives of a simulated arm, which stop by themselves with a deceleration (n,) [rad/s^2]."""

    def __init__(self, plant: Plant, cycle: float, deceleration: np.ndarray, dead_man: float) -> None:
        self._plant, self._cycle = plant, cycle
        self._deceleration, self._dead_man = deceleration, dead_man
        self._position = np.array(plant.measure().position)
        self.stood = self._position  # initial position of the arm, shape (n,) [rad]
        self._velocity = np.zeros_like(self._position)
        self.fault = ""  # why the drives have stopped themselves; empty while they have not
        self.stopped = self._released = False  # whether the drives no longer take commands
        self.blocked = np.zeros(len(self._position), bool)  # whether each joint ignores its commands
        # Velocity of joints that run away, whatever is commanded, until stopped, shape (n,) [rad/s].
        self.runaway = np.zeros(len(self._position))
        self.deaf = False  # whether a quick stop is ignored
        self.refused = 0.0  # highest stop level that the host fails to send to the drives
        self.additive, self._fastest = False, 0.0  # whether commands add up, at most at this speed [rad/s]
        self._began = self._correction = np.zeros(len(self._position))

    def measure(self) -> Measured:
        return self._plant.measure()

    def command(self, position: np.ndarray, velocity: np.ndarray) -> None:
        """Set the position to reach one cycle from now, unless the drives have stopped."""
        if self.additive:
            most = self._cycle * self._fastest
            self._correction = np.clip(position - self._began, -most, most)
        elif not self.stopped:
            idle = self.blocked | self._runs
            self._position = np.where(idle, self._position, position)
            self._velocity = np.where(idle, self.runaway, velocity)

    def hold(self) -> None:
        if not self.stopped:
            self._velocity = np.where(self._runs, self.runaway, 0.0)

    def step(self) -> None:
        if self.stopped:
            before, slower = self._velocity, self._cycle * self._deceleration
            self._velocity = np.sign(before) * np.maximum(np.abs(before) - slower, 0.0)
            self._position = self._position + 0.5 * self._cycle * (before + self._velocity)
        elif self.additive:
            self._position, self._velocity = self._position + self._correction, self._correction / self._cycle
        if self._runs.any():
            self._velocity = np.where(self._runs, self.runaway, self._velocity)
            self._position = self._position + np.where(self._runs, self._cycle * self.runaway, 0.0)
        self._plant.step(self._position, self._velocity, self._cycle)

    @property
    def _runs(self) -> np.ndarray:
        return (self.runaway != 0.0) & (not self.stopped or (self.deaf and not self._released))

    def idle(self, cycles: int) -> None:
        """Simulate cycles without commands; after too many, the dead-man function stops the arm."""
        allowed = round(self._dead_man / self._cycle)
        self.hold()
        for cycle in range(min(cycles, allowed + round(LONGEST_IDLE / self._cycle))):
            if cycle == allowed:
                self.trip(f"no command for {self._dead_man:g} s: the drives have stopped by themselves")
            self.step()

    def stop(self) -> None:
        """Decelerate as the drives do by themselves, and hold from then on."""
        self.stopped = True

    def release(self) -> None:
        """Switch the torque off if the plant supports it: the arm drops."""
        self.stopped = self._released = True
        getattr(self._plant, "release", lambda: None)()

    def add(self, fastest: float) -> None:
        """Add each command as a correction in every cycle from now on, at most at a speed [rad/s]."""
        if not self.additive:
            self._began, self._correction = self._position, np.zeros_like(self._position)
        self.additive, self._fastest = True, fastest

    def trip(self, fault: str) -> None:
        """Stop, and record the reason; the first reason counts."""
        self.fault = self.fault or fault
        self.stop()

    def go(self, away: np.ndarray, seconds: float) -> None:
        """Move the arm smoothly by angles (n,) [rad] before the first exchange."""
        start = self._position
        for share in np.arange(0.0, seconds, self._cycle) / seconds + self._cycle / seconds:
            smooth, speed = share**2 * (3 - 2 * share), 6 * share * (1 - share) / seconds
            self._position, self._velocity = start + smooth * away, speed * away
            self.step()
        self.hold()
