"""Monitors: each checks one quantity in every cycle, and returns the reason if the arm must stop.

Limits on durations are stated in seconds, not in cycles, so that they are the same at every sampling rate.
"""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Sequence

import numpy as np

from exidyn.drivers import Command, Sample, StopLevel
from exidyn.drivers.values import any_of

from .stop import FAULT, SILENT, Stop, UnitOf, revolute_unit

RESTED = 0.2
"""Time without commands after which an arm is at rest [s]: by default, drives then stop by themselves."""


class Monitor(ABC):
    """Checks one quantity in every cycle."""

    @abstractmethod
    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        """The reason to stop after a cycle with this sample and sent command; None if there is none."""


class DriveFault(Monitor):
    """Stops if a drive has stopped itself."""

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        return Stop(StopLevel.QUICK, FAULT, sample.fault) if sample.fault else None


class JointMonitor(Monitor):
    """Stops if a quantity exceeds its limit on a joint for too long.

    Args:
        joints: Names of the joints.
        limit: Limit of each joint, shape (n,); infinite to disable the check.
        cycles: Number of consecutive cycles beyond the limit that stop the arm.
        unit_of: Function that returns the unit of a joint; the class attribute is that of revolute joints.
    """

    kind = ""
    unit = ""
    level = StopLevel.BRAKE

    def __init__(
        self, joints: Sequence[str], limit: np.ndarray, cycles: int, unit_of: UnitOf = revolute_unit
    ) -> None:
        self._joints, self._limit, self._cycles = joints, limit, max(cycles, 1)
        self._unit_of = unit_of
        self._count, self._counting = np.zeros(len(joints), int), False

    @abstractmethod
    def value(self, sample: Sample, sent: Command | None) -> np.ndarray:
        """Quantity to compare with the limit, shape (n,); NaN where unknown."""

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        value = self.value(sample, sent)
        beyond = value > self._limit
        if not self._counting and not any_of(beyond):  # the case in nearly all cycles
            return None
        self._count = np.where(
            beyond, self._counted(beyond, sample), np.where(np.isnan(value), self._count, 0)
        )
        self._counting = bool(self._count.any())
        if (self._count < self._cycles).all():
            return None
        joint = int(np.argmax(self._count))
        size, limit = float(value[joint]), float(self._limit[joint])
        unit = self._unit_of(joint, self.unit)
        text = f"{self._joints[joint]}: {self.kind} {size:.4g} {unit}, limit {limit:.4g}"
        return Stop(self.level, self.kind, text, self._joints[joint], size, limit, unit)

    def _counted(self, beyond: np.ndarray, sample: Sample) -> np.ndarray:
        """Number of consecutive cycles beyond the limit, for joints that are beyond it now, shape (n,)."""
        return self._count + 1


class TrackingError:
    """Distance of the measured position from all recent commands; a delay of the drive is not an error.

    Args:
        memory: Number of cycles within which a command may take effect.
    """

    def __init__(self, memory: int) -> None:
        self._memory, self._next = max(memory, 1), 0
        self._commands = np.zeros((0, 0))
        self._sample: Sample | None = None
        self._error = np.zeros(0)

    def of(self, sample: Sample, sent: Command | None) -> np.ndarray:
        """Tracking error, shape (n,) [rad] or [m]; NaN without commands. Each sample is evaluated once."""
        if sample is not self._sample:
            self._sample, self._error = sample, self._compute(sample, sent)
        return self._error

    def _compute(self, sample: Sample, sent: Command | None) -> np.ndarray:
        position = sample.position
        if sent is None:
            return np.full(len(position), np.nan)
        if not self._next:
            self._commands = np.tile(sent.position, (self._memory, 1))
        self._commands[self._next % self._memory] = sent.position
        self._next += 1
        below = self._commands.min(axis=0) - position
        return np.maximum(np.maximum(below, position - self._commands.max(axis=0)), 0.0)


class Tracking(JointMonitor):
    """Monitors the tracking error computed by `error`; other arguments are those of `JointMonitor`."""

    kind, unit = "tracking error", "rad"

    def __init__(
        self,
        joints: Sequence[str],
        limit: np.ndarray,
        cycles: int,
        error: TrackingError,
        unit_of: UnitOf = revolute_unit,
    ) -> None:
        super().__init__(joints, limit, cycles, unit_of)
        self._error = error

    def value(self, sample: Sample, sent: Command | None) -> np.ndarray:
        return self._error.of(sample, sent)


class Current(JointMonitor):
    """Monitors the motor current in either direction."""

    kind, unit = "current", "A"

    def value(self, sample: Sample, sent: Command | None) -> np.ndarray:
        return np.abs(sample.current)


class Torque(JointMonitor):
    """Monitors the measured joint torque in either direction."""

    kind, unit = "torque", "N m"

    def value(self, sample: Sample, sent: Command | None) -> np.ndarray:
        return np.abs(sample.torque)


class Temperature(JointMonitor):
    """Monitors the motor temperature; if it is not read in every cycle, the time between readings counts.

    `cycle` is the time between samples [s]; other arguments are those of `JointMonitor`.
    """

    kind, unit = "temperature", "degC"

    def __init__(self, joints: Sequence[str], limit: np.ndarray, cycles: int, cycle: float) -> None:
        super().__init__(joints, limit, cycles)
        self._cycle = 1e9 * cycle
        self._read = np.zeros(len(joints))

    def value(self, sample: Sample, sent: Command | None) -> np.ndarray:
        return sample.temperature

    def _counted(self, beyond: np.ndarray, sample: Sample) -> np.ndarray:
        since = np.maximum(np.rint((sample.host_time - self._read) / self._cycle), 1.0)
        self._read = np.where(np.isnan(sample.temperature), self._read, sample.host_time)
        return np.where(self._count > 0, self._count + since, 1)


class Outside(JointMonitor):
    """Monitors positions beyond `lower` or `upper` by more than `slack`, each shape (n,) [rad] or [m].

    A joint that starts outside may move back inside. Other arguments are those of `JointMonitor`.
    """

    kind, unit = "position beyond its limits by", "rad"

    def __init__(
        self,
        joints: Sequence[str],
        lower: np.ndarray,
        upper: np.ndarray,
        slack: np.ndarray,
        cycles: int,
        unit_of: UnitOf = revolute_unit,
    ) -> None:
        super().__init__(joints, slack, cycles, unit_of)
        self._lower, self._upper = lower, upper

    def value(self, sample: Sample, sent: Command | None) -> np.ndarray:
        if sent is None:
            self._lower = np.fmin(self._lower, sample.position)
            self._upper = np.fmax(self._upper, sample.position)
        return np.maximum(self._lower - sample.position, sample.position - self._upper)


class Speed(JointMonitor):
    """Monitors the measured speed, averaged over a window so that a coarse encoder raises no alarm.

    `limit` has shape (n,) [rad/s] or [m/s], `window` is in cycles, and `cycle` is the sampling period [s].
    Other arguments are those of `JointMonitor`.
    """

    kind, unit = "speed", "rad/s"

    def __init__(
        self,
        joints: Sequence[str],
        limit: np.ndarray,
        window: int,
        cycle: float,
        unit_of: UnitOf = revolute_unit,
    ) -> None:
        super().__init__(joints, limit, window, unit_of)
        self._cycle = cycle
        self._window = max(window, 1)
        self._recent = deque[tuple[int, np.ndarray]](maxlen=self._window + 1)

    def value(self, sample: Sample, sent: Command | None) -> np.ndarray:
        self._recent.append((sample.host_time, sample.position))
        if len(self._recent) <= self._window:
            return np.zeros(len(sample.position))
        time, position = self._recent[0]
        duration = max((sample.host_time - time) * 1e-9, self._window * self._cycle)
        return np.abs(sample.position - position) / duration


class Silence(Monitor):
    """Stops if a joint has no fresh sample or position for too many consecutive cycles."""

    def __init__(self, joints: Sequence[str], cycles: int) -> None:
        self._joints, self._cycles = joints, max(cycles, 1)
        self._count, self._counting = np.zeros(len(joints), int), False

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        silent = sample.stale | np.isnan(sample.position)
        if not self._counting and not any_of(silent):
            return None
        self._count = np.where(silent, self._count + 1, 0)
        self._counting = bool(self._count.any())
        if (self._count < self._cycles).all():
            return None
        names = [name for name, count in zip(self._joints, self._count, strict=True) if count >= self._cycles]
        text = f"nothing was received from {', '.join(names)} for {self._count.max()} cycles"
        return Stop(StopLevel.QUICK, SILENT, text, names[0], float(self._count.max()), self._cycles, "cycles")


class Stale(Monitor):
    """Stops if a joint was silent in too many samples of the last second, however briefly each time.

    Args:
        cycle: Time between samples [s].
        share: Allowed share of the last second's samples [-].
        least: Number of such samples that is always allowed.
    """

    def __init__(self, cycle: float, share: float, least: int) -> None:
        second = max(round(1.0 / cycle), 1)
        self._share, self._least = share, least
        self._stale, self._sum = deque([0] * second, maxlen=second), 0

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        stale = int(any_of(sample.stale))
        self._sum += stale - self._stale[0]
        self._stale.append(stale)
        share = self._sum / len(self._stale)
        if share <= self._share or self._sum <= self._least:
            return None
        text = (
            f"a joint was silent in {100 * share:.0f} % of the last second's samples, limit "
            f"{100 * self._share:.0f} %. Check cable, termination and load of the bus"
        )
        return Stop(StopLevel.BRAKE, "stale samples", text, "", share, self._share, "")


class Lateness(Monitor):
    """Stops after a long time without commands, or if too many cycles of the last second had none.

    A cycle in which the controller did not ask for a command counts as missed too. A long stall
    causes a quick stop: without commands the arm has stopped, and a controlled stop would move it again.

    Args:
        cycle: Time between exchanges [s].
        stall: Maximum time without an exchange [s].
        share: Allowed share of missed cycles in the last second [-].
    """

    def __init__(self, cycle: float, stall: float, share: float) -> None:
        self._cycle, self._stall, self._share = cycle, stall, share
        second = max(round(1.0 / cycle), 1)
        self._missed = deque([0] * second, maxlen=second)
        self._sum = 0

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        if sent is None and sample.sent:
            return None
        stalled = sample.skipped * self._cycle
        if stalled > self._stall:
            text = f"no cycle for {1e3 * stalled:.0f} ms, limit {1e3 * self._stall:.0f} ms"
            level = StopLevel.QUICK if stalled > RESTED else StopLevel.BRAKE
            return Stop(level, "stall", text, "", stalled, self._stall, "s")
        self._sum += sample.skipped + (not sample.sent) - self._missed[0]
        self._missed.append(sample.skipped + (not sample.sent))
        missed = self._sum / len(self._missed)
        if missed <= self._share:
            return None
        text = (
            f"{100 * missed:.0f} % of the last second's cycles were missed, limit {100 * self._share:.0f} %"
        )
        return Stop(StopLevel.BRAKE, "lateness", text, "", float(missed), self._share, "")
