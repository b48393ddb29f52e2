"""Monitors: each checks one quantity in every cycle, and returns the reason if the arm must stop."""

from collections import deque
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from exidyn.drivers import StopLevel
from exidyn.drivers.values import any_of
from exidyn.identification.arm.robot import Limits, Robot

from .history import Excess, History
from .stop import FAULT, SILENT, Stop

RESTED = 0.2
"""Time without commands after which an arm is at rest [s]: by default, drives then stop by themselves."""
CLOCK_WINDOW = 2.0
"""Window for comparing the controller's clock with the host's, as a multiple of the maximum stall [-]."""
CLOCK_RATE = 0.5
"""Minimum rate of the controller's clock, as a share of the host's [-]: rates differ by 1e-4, and a sample
that is late by the maximum stall lowers the share to two thirds."""
CLOCK_CYCLES = 5
"""Consecutive cycles below this rate that stop the arm."""

Monitor = Callable[[History], Stop | None]
"""The reason to stop after the last cycle of a history; None if there is none."""


def drive_fault(history: History) -> Stop | None:
    """Stops if a drive has stopped itself."""
    fault = history.sample.fault
    return Stop(StopLevel.QUICK, FAULT, fault) if fault else None


class JointRule(NamedTuple):
    """A quantity that causes a controlled stop if it exceeds its limit on a joint for too long."""

    kind: str  # name of the quantity, and kind of the stop
    # Function that returns the quantity, shape (n,); NaN where unknown.
    signal: Callable[[History], np.ndarray]
    limit: np.ndarray  # limit of each joint, shape (n,); infinite to disable the check
    seconds: float  # duration beyond the limit that stops the arm [s], the same at every sampling rate
    unit: str  # unit of value and limit on revolute joints
    # Whether the time between readings counts, for quantities that are not read in every cycle.
    gaps: bool = False


class JointMonitor:
    """Checks a rule on all joints, in cycles of a given duration [s]."""

    def __init__(self, rule: JointRule, robot: Robot, cycle: float) -> None:
        self._rule, self._robot, self._cycle = rule, robot, 1e9 * cycle
        self._cycles = max(round(rule.seconds / cycle), 1)
        self._excess = Excess(robot.dof)
        self._read = np.zeros(robot.dof)  # time of each joint's last reading while any exceeds its limit [ns]

    def look(self, history: History) -> Stop | None:
        rule, value, now = self._rule, self._rule.signal(history), history.sample.host_time
        gap: np.ndarray | int = 1
        if rule.gaps and self._excess.counting:
            gap = np.maximum(np.rint((now - self._read) / self._cycle), 1.0)
        if not self._excess.add(value, rule.limit, 0.0, gap):
            return None
        self._read = np.where(np.isnan(value), self._read, now)
        count = self._excess.count
        if (count < self._cycles).all():
            return None
        joint = int(np.argmax(count))
        size, limit = float(value[joint]), float(rule.limit[joint])
        name, unit = self._robot.joints[joint], self._robot.unit(joint, rule.unit)
        text = f"{name}: {rule.kind} {size:.4g} {unit}, limit {limit:.4g}"
        return Stop(StopLevel.BRAKE, rule.kind, text, name, size, limit, unit)


class Outside:
    """Distance of each joint beyond its position limits; a joint that starts outside may move back inside."""

    def __init__(self, limits: Limits) -> None:
        self._lower, self._upper = limits.position_lower, limits.position_upper

    def distance(self, history: History) -> np.ndarray:
        """Distance beyond the limits, shape (n,) [rad] or [m]; negative inside."""
        position = history.sample.position
        if history.sent is None:
            self._lower, self._upper = np.fmin(self._lower, position), np.fmax(self._upper, position)
        return np.maximum(self._lower - position, position - self._upper)


def mean_speed(history: History, cycles: int, cycle: float) -> np.ndarray:
    """Speed over some cycles, since steps of an encoder are no motion, shape (n,) [rad/s] or [m/s]."""
    earlier, sample = history.before(cycles), history.sample
    if earlier is None:
        return np.zeros(len(sample.position))
    time, position = earlier
    duration = max((sample.host_time - time) * 1e-9, cycles * cycle)
    return np.abs(sample.position - position) / duration


class Silence:
    """Stops if a joint has no fresh sample or position for too many consecutive cycles."""

    def __init__(self, joints: Sequence[str], cycles: int) -> None:
        self._joints, self._cycles = joints, max(cycles, 1)
        self._excess, self._limit = Excess(len(joints)), np.zeros(len(joints))

    def look(self, history: History) -> Stop | None:
        silent = history.sample.stale | np.isnan(history.sample.position)
        if not self._excess.add(silent, self._limit, 0.0):
            return None
        count = self._excess.count
        if (count < self._cycles).all():
            return None
        names = [name for name, cycles in zip(self._joints, count, strict=True) if cycles >= self._cycles]
        text = f"nothing was received from {', '.join(names)} for {count.max()} cycles"
        return Stop(StopLevel.QUICK, SILENT, text, names[0], float(count.max()), self._cycles, "cycles")


class LastSecond:
    """Numbers of the last second's cycles, and their sum; `cycle` is the time between them [s]."""

    def __init__(self, cycle: float) -> None:
        second = max(round(1.0 / cycle), 1)
        self._numbers, self.sum = deque([0] * second, maxlen=second), 0

    def add(self, number: int) -> float:
        """Add the number of a cycle, and return the mean."""
        self.sum += number - self._numbers[0]
        self._numbers.append(number)
        return self.sum / len(self._numbers)


class Stale:
    """Stops if a joint was silent in too many samples of the last second, however briefly each time.

    Args:
        cycle: Time between samples [s].
        share: Allowed share of the last second's samples [-].
        least: Number of such samples that is always allowed.
    """

    def __init__(self, cycle: float, share: float, least: int) -> None:
        self._share, self._least, self._stale = share, least, LastSecond(cycle)

    def look(self, history: History) -> Stop | None:
        share = self._stale.add(int(any_of(history.sample.stale)))
        if share <= self._share or self._stale.sum <= self._least:
            return None
        text = (
            f"a joint was silent in {100 * share:.0f} % of the last second's samples, limit "
            f"{100 * self._share:.0f} %. Check cable, termination and load of the bus"
        )
        return Stop(StopLevel.BRAKE, "stale samples", text, "", share, self._share, "")


class Lateness:
    """Stops after a long time without commands, or if too many cycles of the last second had none.

    A cycle in which the controller did not ask for a command counts as missed too. A long stall
    causes a quick stop: without commands the arm has stopped, and a controlled stop would move it again.

    Args:
        cycle: Time between exchanges [s].
        stall: Maximum time without an exchange [s].
        share: Allowed share of missed cycles in the last second [-].
    """

    def __init__(self, cycle: float, stall: float, share: float) -> None:
        self._cycle, self._stall, self._share, self._missed = cycle, stall, share, LastSecond(cycle)

    def look(self, history: History) -> Stop | None:
        sample = history.sample
        if history.sent is None and sample.sent:
            return None
        stalled = sample.skipped * self._cycle
        if stalled > self._stall:
            text = f"no cycle for {1e3 * stalled:.0f} ms, limit {1e3 * self._stall:.0f} ms"
            level = StopLevel.QUICK if stalled > RESTED else StopLevel.BRAKE
            return Stop(level, "stall", text, "", stalled, self._stall, "s")
        missed = self._missed.add(sample.skipped + (not sample.sent))
        if missed <= self._share:
            return None
        text = (
            f"{100 * missed:.0f} % of the last second's cycles were missed, limit {100 * self._share:.0f} %"
        )
        return Stop(StopLevel.BRAKE, "lateness", text, "", float(missed), self._share, "")


class ControllerClock:
    """Monitors the controller's clock, the time base of the recording: it must advance while samples come.

    `cycle` is the time between exchanges, `stall` the maximum time without an exchange [s].
    """

    def __init__(self, cycle: float, stall: float) -> None:
        window = max(round(CLOCK_WINDOW * stall / cycle), CLOCK_CYCLES)
        self._times = deque[tuple[int, int]](maxlen=window + 1)
        self._count = 0

    def look(self, history: History) -> Stop | None:
        sample = history.sample
        if sample.stale.size and not any_of(~sample.stale):  # no sample, so no new time
            return None
        self._times.append((sample.host_time, sample.controller_time))
        if len(self._times) < (self._times.maxlen or 0):
            return None
        (host_start, controller_start), (host_end, controller_end) = self._times[0], self._times[-1]
        host, controller = 1e-9 * (host_end - host_start), 1e-9 * (controller_end - controller_start)
        self._count = self._count + 1 if controller < CLOCK_RATE * host else 0
        if self._count < CLOCK_CYCLES:
            return None
        text = (
            f"the controller's clock advanced by {controller:.3f} s in {host:.3f} s: the times of its "
            "samples cannot be trusted. Restart the controller"
        )
        return Stop(StopLevel.QUICK, "controller clock", text, "", controller, CLOCK_RATE * host, "s")
