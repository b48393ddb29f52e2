"""The mock's controller: what it does with commands, without them, and when it has to stop by itself."""

import numpy as np

from .driver import Measured, Plant

LONGEST_IDLE = 2.0
"""Of a time without exchanges, no more is simulated: by then every drive has stopped [s]."""


class MockDrives:
    """Drives of a simulated arm.

    Args:
        plant: The arm.
        cycle: Time from command to command [s].
        deceleration: With which they stop by themselves, shape (n,) [rad/s^2].
        dead_man: Time without an exchange after which they do [s].

    Attributes:
        fault: Why they have stopped themselves; empty while they have not.
        stopped: Whether they take no commands any more.
        blocked: Joints that do not follow, shape (n,).
    """

    def __init__(self, plant: Plant, cycle: float, deceleration: np.ndarray, dead_man: float) -> None:
        self._plant, self._cycle = plant, cycle
        self._deceleration, self._dead_man = deceleration, dead_man
        self._position = np.array(plant.measure().position)
        self._velocity = np.zeros_like(self._position)
        self.fault, self.stopped = "", False
        self.blocked = np.zeros(len(self._position), bool)

    def measure(self) -> Measured:
        """What the sensors say now."""
        return self._plant.measure()

    def command(self, position: np.ndarray, velocity: np.ndarray) -> None:
        """Take what is to be reached one cycle from now, unless they have stopped."""
        if not self.stopped:
            self._position = np.where(self.blocked, self._position, position)
            self._velocity = np.where(self.blocked, 0.0, velocity)

    def hold(self) -> None:
        """Stay at the last command."""
        if not self.stopped:
            self._velocity = np.zeros_like(self._velocity)

    def step(self) -> None:
        """One cycle goes by."""
        if self.stopped:
            before, slower = self._velocity, self._cycle * self._deceleration
            self._velocity = np.sign(before) * np.maximum(np.abs(before) - slower, 0.0)
            self._position = self._position + 0.5 * self._cycle * (before + self._velocity)
        self._plant.step(self._position, self._velocity, self._cycle)

    def idle(self, cycles: int) -> None:
        """Cycles go by in which nobody commands; after too many the dead-man stops the arm."""
        allowed = round(self._dead_man / self._cycle)
        self.hold()
        for cycle in range(min(cycles, allowed + round(LONGEST_IDLE / self._cycle))):
            if cycle == allowed:
                self.trip(f"no command for {self._dead_man:g} s: the drives have stopped by themselves")
            self.step()

    def stop(self) -> None:
        """Brake as hard as they do by themselves, and hold from then on."""
        self.stopped = True

    def release(self) -> None:
        """Take the torque away, where the plant can: the arm drops."""
        self.stopped = True
        getattr(self._plant, "release", lambda: None)()

    def trip(self, fault: str) -> None:
        """Stop, and say why; the first reason counts."""
        self.fault = self.fault or fault
        self.stop()

    def go(self, away: np.ndarray, seconds: float) -> None:
        """Move the arm by some angles (n,) [rad], smoothly, before anything begins."""
        start = self._position
        for share in np.arange(0.0, seconds, self._cycle) / seconds + self._cycle / seconds:
            smooth, speed = share**2 * (3 - 2 * share), 6 * share * (1 - share) / seconds
            self._position, self._velocity = start + smooth * away, speed * away
            self.step()
        self.hold()
