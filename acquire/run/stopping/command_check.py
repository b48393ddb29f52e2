"""The last look at a command before it is sent: what is not in order is not sent, and nothing is clamped."""

from collections.abc import Sequence

import numpy as np

from exidyn.drivers import Command, StopLevel
from exidyn.drivers.values import any_of
from exidyn.identify.arm.robot import Limits

from .stop import Stop, UnitOf, turning

SLACK = 1.05
"""Share of the velocity and acceleration limits up to which differences of commands may go: what a tick's
rounding and a limit that is reached between two ticks can make of them."""
SLOWEST = 1e-6
"""Step below which a command counts as standing still [rad]: a tenth of what encoders see."""


class CommandCheck:
    """Looks at each command and the two before it.

    Args:
        joints: Names.
        limits: Of the robot; infinite ones are not looked at.
        window_lower: Lowest position that the controller takes, shape (n,) [rad].
        window_upper: Highest, likewise.
        cycle: Time between commands [s].
        start: Where the arm stood before the first, shape (n,) [rad] or [m].
        unit_of: Unit of a joint.
    """

    def __init__(
        self,
        joints: Sequence[str],
        limits: Limits,
        cycle: float,
        start: np.ndarray,
        window_lower: np.ndarray | None = None,
        window_upper: np.ndarray | None = None,
        unit_of: UnitOf = turning,
    ) -> None:
        self._joints, self._unit_of = joints, unit_of
        lower = (
            limits.position_lower if window_lower is None else np.maximum(limits.position_lower, window_lower)
        )
        upper = (
            limits.position_upper if window_upper is None else np.minimum(limits.position_upper, window_upper)
        )
        # Let back in from where it stands, should that be outside, but no further out.
        self._lower, self._upper = np.minimum(lower, start) - SLOWEST, np.maximum(upper, start) + SLOWEST
        self._step = SLACK * np.maximum(limits.velocity, -limits.velocity_lower) * cycle + SLOWEST
        most = np.maximum(limits.acceleration, -limits.acceleration_lower)
        self._change = SLACK * most * cycle**2 + SLOWEST
        self._cycle = cycle
        self._before, self._step_before = start, np.zeros(len(start))

    def look(self, command: Command) -> Stop | None:
        """Why a command must not be sent; None if it may, and then the next is held against it."""
        position = command.position
        if position.shape != self._before.shape or not np.isfinite(position).all():
            return self._stop("command", 0, float("nan"), 0.0, "rad", "is not a number")
        step = position - self._before
        found = self._beyond(position, step)
        if found is None:
            self._before, self._step_before = position, step
        return found

    def _beyond(self, position: np.ndarray, step: np.ndarray) -> Stop | None:
        beyond = (position < self._lower) | (position > self._upper)
        if any_of(beyond):
            j = int(np.argmax(beyond))
            limit = self._lower[j] if position[j] < self._lower[j] else self._upper[j]
            return self._stop("command position", j, position[j], limit, "rad", "is beyond the limit of")
        if any_of(np.abs(step) > self._step):
            j = int(np.argmax(np.abs(step) - self._step))
            value, limit = step[j] / self._cycle, self._step[j] / self._cycle
            return self._stop("command velocity", j, value, limit, "rad/s", "is beyond the limit of")
        change = step - self._step_before
        if any_of(np.abs(change) > self._change):
            j = int(np.argmax(np.abs(change) - self._change))
            value, limit = change[j] / self._cycle**2, self._change[j] / self._cycle**2
            return self._stop("command acceleration", j, value, limit, "rad/s^2", "is beyond the limit of")
        return None

    def _stop(self, kind: str, joint: int, value: float, limit: float, unit: str, words: str) -> Stop:
        name, unit = self._joints[joint], self._unit_of(joint, unit)
        text = f"{name}: {kind} {value:.4g} {unit} {words}" + ("" if "not" in words else f" {limit:.4g}")
        return Stop(StopLevel.BRAKE, kind, text, name, float(value), float(limit), unit)
