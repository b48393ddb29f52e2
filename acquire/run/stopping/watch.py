"""Watch: all monitors of a run, and their limits; and the last look at a command before it is sent."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exidyn.drivers import Command, Info, Sample, StopLevel
from exidyn.drivers.values import any_of
from exidyn.identification.arm.robot import Limits, Robot

from . import monitors
from .monitors import Monitor
from .stop import Stop, UnitOf, harder, turning

CLOCK_WINDOW = 2.0
"""Time over which the controller's clock is held against the host's, over the longest stall that is borne
[-]."""
CLOCK_RATE = 0.5
"""Of the host's rate, below which the controller's clock does not keep time [-]: clocks differ by 1e-4, and a
sample that is late by the longest stall makes two thirds of the window."""
CLOCK_CYCLES = 5
"""Cycles in a row after which that is sure."""
SLACK = 1.05
"""Share of the velocity and acceleration limits up to which differences of commands may go: what a tick's
rounding and a limit that is reached between two ticks can make of them."""
SLOWEST = 1e-6
"""Step below which a command counts as standing still [rad]: a tenth of what encoders see."""


@dataclass(frozen=True)
class WatchLimits:
    """What is still in order while the arm moves.

    Attributes:
        tracking: Distance from what was commanded [rad] or [m]: two degrees, many times what a sound drive
            is behind, and what a link of one metre moves by 35 mm.
        tracking_time: How long it may be further [s].
        outside: How far beyond its position limits a joint may be [rad] or [m], whatever `tracking` is: what
            a sound drive is behind.
        delay: Time within which a command takes effect [s]; no motion of that time is a tracking error.
        effort: Share of the torque limits, or of the currents that make them, above which to stop [-].
        effort_time: How long it may be above [s]; gears bear short peaks.
        temperature: Highest of a motor [degC]; what most windings bear, less a margin.
        speed: Share of the velocity limits above which to stop [-].
        silence: How long a joint may be silent [s].
        least_silence: Cycles of silence that are borne at any rate.
        stall: Longest time without a cycle [s].
        missed: Share of a second's cycles that may be missed [-].
        stale: Share of a second's samples in which a joint may be silent [-]: filled in between the others, a
            tenth does not change what is identified.
    """

    tracking: float = 0.035
    tracking_time: float = 0.05
    outside: float = 0.035
    delay: float = 0.05
    effort: float = 1.2
    effort_time: float = 0.05
    temperature: float = 85.0
    speed: float = 1.2
    silence: float = 0.01
    least_silence: int = 5
    stall: float = 0.05
    missed: float = 0.05
    stale: float = 0.1

    def silent_cycles(self, cycle: float) -> int:
        """For how many cycles in a row a joint may be silent, given the time of one [s]."""
        return max(round(self.silence / cycle), self.least_silence)


class Watch:
    """All monitors at once.

    Args:
        robot: The arm, which has limits.
        info: Cycle of the controller.
        limits: What is in order.
        current: Largest current, shape (n,) [A], in place of what makes the largest torque.
    """

    def __init__(
        self, robot: Robot, info: Info, limits: WatchLimits, current: np.ndarray | None = None
    ) -> None:
        # A command is seen in the next cycle's sample at the earliest, however long the cycle is.
        self.tracking_error = monitors.TrackingError(max(round(limits.delay / info.cycle), 2))
        self._monitors = _monitors(robot, info, limits, current, self.tracking_error)

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        """The most severe reason to stop after this cycle, or None."""
        found: Stop | None = None
        for monitor in self._monitors:
            found = harder(found, monitor.look(sample, sent))
        return found


def _monitors(
    robot: Robot,
    info: Info,
    watch: WatchLimits,
    current: np.ndarray | None,
    tracking_error: monitors.TrackingError,
) -> tuple[monitors.Monitor, ...]:
    joints, limits, cycle, unit = robot.joints, robot.limits, info.cycle, robot.unit
    far, outside = np.full(robot.dof, watch.tracking), np.full(robot.dof, watch.outside)
    with np.errstate(divide="ignore"):
        by_torque = watch.effort * limits.torque / np.abs(robot.drive_gain)
    speed = watch.speed * np.maximum(limits.velocity, -limits.velocity_lower)
    long, effort = round(watch.tracking_time / cycle), round(watch.effort_time / cycle)
    return (
        monitors.DriveFault(),
        monitors.Silence(joints, watch.silent_cycles(cycle)),
        ControllerClock(cycle, watch.stall),
        monitors.Tracking(joints, far, long, tracking_error, unit),
        monitors.Outside(joints, limits.position_lower, limits.position_upper, outside, long, unit),
        monitors.Speed(joints, speed, max(round(0.02 / cycle), 2), cycle, unit),
        monitors.Current(joints, by_torque if current is None else current, effort),
        monitors.Torque(joints, watch.effort * limits.torque, effort, unit),
        monitors.Temperature(joints, np.full(robot.dof, watch.temperature), round(1.0 / cycle), cycle),
        monitors.Stale(cycle, watch.stale, watch.least_silence),
        monitors.Lateness(cycle, watch.stall, watch.missed),
    )


class ControllerClock(Monitor):
    """The controller's clock, which goes on while samples come; all times of the recording are by it.

    `cycle` is the time between exchanges, `stall` the longest time without one [s].
    """

    def __init__(self, cycle: float, stall: float) -> None:
        window = max(round(CLOCK_WINDOW * stall / cycle), CLOCK_CYCLES)
        self._times = deque[tuple[int, int]](maxlen=window + 1)
        self._count = 0

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        if sample.stale.size and not any_of(~sample.stale):  # nothing came, so no time either
            return None
        self._times.append((sample.host_time, sample.controller_time))
        if len(self._times) < (self._times.maxlen or 0):
            return None
        (began, zero), (now, time) = self._times[0], self._times[-1]
        host, controller = 1e-9 * (now - began), 1e-9 * (time - zero)
        self._count = self._count + 1 if controller < CLOCK_RATE * host else 0
        if self._count < CLOCK_CYCLES:
            return None
        text = (
            f"the controller's clock went on by {controller:.3f} s in {host:.3f} s while samples came: their "
            "times cannot be trusted. Restart the controller"
        )
        return Stop(StopLevel.QUICK, "controller clock", text, "", controller, CLOCK_RATE * host, "s")


class CommandCheck:
    """Looks at each command and the two before it; what is not in order is not sent, and nothing is clamped.

    Args:
        joints: Names.
        limits: Limits of the robot; infinite ones are not looked at.
        cycle: Time between commands [s].
        start: Where the arm stood before the first, shape (n,) [rad] or [m].
        window_lower: Lowest position that the controller takes, shape (n,) [rad] or [m].
        window_upper: Highest position, shape (n,) [rad] or [m].
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
        lower = np.maximum(limits.position_lower, -np.inf if window_lower is None else window_lower)
        upper = np.minimum(limits.position_upper, np.inf if window_upper is None else window_upper)
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
