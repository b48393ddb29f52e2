"""Monitors: each watches one thing, every cycle, and gives the reason why the arm must stop.

What counts as too long is stated as time and not as cycles, so that it means the same at every rate.
"""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Sequence

import numpy as np

from exidyn.drivers import Command, Sample, StopLevel
from exidyn.drivers.values import any_of

from .stop import FAULT, SILENT, Stop, UnitOf, turning

RESTED = 0.2
"""Time without commands after which an arm rests [s]: drives stop by themselves by default then."""


class Monitor(ABC):
    """Watches one thing."""

    @abstractmethod
    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        """Why to stop after this cycle, in which a command was sent; None while all is well."""


class DriveFault(Monitor):
    """A drive that has stopped itself."""

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        return Stop(StopLevel.QUICK, FAULT, sample.fault) if sample.fault else None


class JointMonitor(Monitor):
    """Something that must not be beyond a limit on any joint for too long.

    Args:
        joints: Names.
        limit: Shape (n,); infinite where nothing is watched.
        cycles: For how many cycles in a row it may be.
        unit_of: Unit of a joint; the class states that of revolute ones.
    """

    kind = ""
    unit = ""
    level = StopLevel.BRAKE

    def __init__(
        self, joints: Sequence[str], limit: np.ndarray, cycles: int, unit_of: UnitOf = turning
    ) -> None:
        self._joints, self._limit, self._cycles = joints, limit, max(cycles, 1)
        self._unit_of = unit_of
        self._count, self._counting = np.zeros(len(joints), int), False

    @abstractmethod
    def value(self, sample: Sample, sent: Command | None) -> np.ndarray:
        """What is held against the limit, shape (n,); NaN where unknown."""

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        value = self.value(sample, sent)
        beyond = value > self._limit
        if not self._counting and not any_of(beyond):  # as in nearly all cycles
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
        """For how many cycles in a row joints that are beyond their limit have been, shape (n,)."""
        return self._count + 1


class TrackingError:
    """Measured position away from all that was commanded lately, so that a delay of the drive is no error.

    Args:
        memory: Cycles over which a command may take effect.
    """

    def __init__(self, memory: int) -> None:
        self._memory, self._next = max(memory, 1), 0
        self._commands = np.zeros((0, 0))
        self._sample: Sample | None = None
        self._error = np.zeros(0)

    def of(self, sample: Sample, sent: Command | None) -> np.ndarray:
        """Shape (n,) [rad] or [m]; NaN where nothing was commanded. Computed once for the same sample."""
        if sample is not self._sample:
            self._sample, self._error = sample, self._computed(sample, sent)
        return self._error

    def _computed(self, sample: Sample, sent: Command | None) -> np.ndarray:
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
    """The tracking error [rad] or [m], as `error` computes it; else as `JointMonitor`."""

    kind, unit = "tracking error", "rad"

    def __init__(
        self,
        joints: Sequence[str],
        limit: np.ndarray,
        cycles: int,
        error: TrackingError,
        unit_of: UnitOf = turning,
    ) -> None:
        super().__init__(joints, limit, cycles, unit_of)
        self._error = error

    def value(self, sample: Sample, sent: Command | None) -> np.ndarray:
        return self._error.of(sample, sent)


class Current(JointMonitor):
    """Motor current, either way."""

    kind, unit = "current", "A"

    def value(self, sample: Sample, sent: Command | None) -> np.ndarray:
        return np.abs(sample.current)


class Torque(JointMonitor):
    """Measured joint torque, either way."""

    kind, unit = "torque", "N m"

    def value(self, sample: Sample, sent: Command | None) -> np.ndarray:
        return np.abs(sample.torque)


class Temperature(JointMonitor):
    """Motor temperature, which some drives send in a few cycles only: then the time between readings counts.

    `cycle` is the time between samples [s]; else as `JointMonitor`.
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
    """Measured position beyond `lower` and `upper` by more than `slack`, each shape (n,) [rad] or [m].

    What began outside may move back in. Else as `JointMonitor`.
    """

    kind, unit = "position beyond its limits by", "rad"

    def __init__(
        self,
        joints: Sequence[str],
        lower: np.ndarray,
        upper: np.ndarray,
        slack: np.ndarray,
        cycles: int,
        unit_of: UnitOf = turning,
    ) -> None:
        super().__init__(joints, slack, cycles, unit_of)
        self._lower, self._upper = lower, upper

    def value(self, sample: Sample, sent: Command | None) -> np.ndarray:
        if sent is None:
            self._lower = np.fmin(self._lower, sample.position)
            self._upper = np.fmax(self._upper, sample.position)
        return np.maximum(self._lower - sample.position, sample.position - self._upper)


class Speed(JointMonitor):
    """Measured speed, as mean over a window [cycles] long enough that a coarse encoder does not alarm.

    The limit is of shape (n,) [rad/s] or [m/s], `cycle` the time between samples [s]; else as `JointMonitor`.
    """

    kind, unit = "speed", "rad/s"

    def __init__(
        self, joints: Sequence[str], limit: np.ndarray, window: int, cycle: float, unit_of: UnitOf = turning
    ) -> None:
        super().__init__(joints, limit, window, unit_of)
        self._cycle = cycle
        self._window = max(window, 1)
        self._seen = deque[tuple[int, np.ndarray]](maxlen=self._window + 1)

    def value(self, sample: Sample, sent: Command | None) -> np.ndarray:
        self._seen.append((sample.host_time, sample.position))
        if len(self._seen) <= self._window:
            return np.zeros(len(sample.position))
        time, position = self._seen[0]
        gone = max((sample.host_time - time) * 1e-9, self._window * self._cycle)
        return np.abs(sample.position - position) / gone


class Silence(Monitor):
    """A joint without fresh samples, or whose position is not a number, for too many cycles in a row."""

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
    """Too many of the last second's samples in which a joint was silent, though never for long.

    Args:
        cycle: Time between samples [s].
        share: Share of a second's samples that may be [-].
        least: Number of them that is borne at any rate.
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
            f"{100 * self._share:.0f} %: look at cable, termination and load of the bus"
        )
        return Stop(StopLevel.BRAKE, "stale samples", text, "", share, self._share, "")


class Lateness(Monitor):
    """Cycles that went by without a command: one long stall, or too many of the last second's.

    A controller that did not ask has missed one too, though the loop came round. After a stall in which an
    arm that gets no commands has come to rest, a controlled stop would set it in motion again, so that it is
    a quick stop.

    Args:
        cycle: Time between exchanges [s].
        stall: Longest time without one [s].
        share: Share of a second's cycles that may be missed [-].
    """

    def __init__(self, cycle: float, stall: float, share: float) -> None:
        self._cycle, self._stall, self._share = cycle, stall, share
        second = max(round(1.0 / cycle), 1)
        self._missed = deque([0] * second, maxlen=second)
        self._sum = 0

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        if sent is None and sample.sent:
            return None
        gone = sample.skipped * self._cycle
        if gone > self._stall:
            text = f"no cycle for {1e3 * gone:.0f} ms, limit {1e3 * self._stall:.0f} ms"
            level = StopLevel.QUICK if gone > RESTED else StopLevel.BRAKE
            return Stop(level, "stall", text, "", gone, self._stall, "s")
        self._sum += sample.skipped + (not sample.sent) - self._missed[0]
        self._missed.append(sample.skipped + (not sample.sent))
        missed = self._sum / len(self._missed)
        if missed <= self._share:
            return None
        text = (
            f"{100 * missed:.0f} % of the last second's cycles were missed, limit {100 * self._share:.0f} %"
        )
        return Stop(StopLevel.BRAKE, "lateness", text, "", float(missed), self._share, "")
