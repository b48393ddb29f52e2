"""Watch: all monitors of a run with their limits, and the final check of each command."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exidyn.drivers import Command, Info, Sample, StopLevel
from exidyn.drivers.values import any_of
from exidyn.identification.arm.robot import Limits, Robot

from . import monitors
from .monitors import Monitor
from .stop import Stop, UnitOf, harder, revolute_unit

CLOCK_WINDOW = 2.0
"""Window for comparing the controller's clock with the host's, as a multiple of the maximum stall [-]."""
CLOCK_RATE = 0.5
"""Minimum rate of the controller's clock, as a share of the host's [-]: rates differ by 1e-4, and a sample
that is late by the maximum stall lowers the share to two thirds."""
CLOCK_CYCLES = 5
"""Consecutive cycles below this rate that stop the arm."""
SLACK = 1.05
"""Share of the velocity and acceleration limits that differences of commands may reach [-]: it allows for
rounding and for extremes between two samples."""
STEP_TOLERANCE = 1e-6
"""Step below which commands count as at rest [rad]: a tenth of an encoder step."""


@dataclass(frozen=True)
class WatchLimits:
    """Limits of the monitors while the arm moves.

    Attributes:
        tracking: Maximum tracking error [rad] or [m]: two degrees, which is many times the lag of a sound
            drive and moves the end of a 1 m link by 35 mm.
        tracking_time: Maximum time beyond `tracking` or `outside` [s].
        outside: Maximum distance beyond the position limits [rad] or [m], independent of `tracking`: the lag
            of a sound drive.
        delay: Time within which a command takes effect [s]; motion in this time is not a tracking error.
        effort: Maximum torque over the torque limit, or current over the current that makes it [-].
        effort_time: Maximum time beyond `effort` [s]; gears withstand short peaks.
        temperature: Maximum motor temperature [degC]: what most windings withstand, less a margin.
        speed: Maximum speed over the velocity limit [-].
        silence: Maximum time for which a joint may be silent [s].
        least_silence: Number of silent cycles that is allowed at any sampling rate.
        stall: Maximum time without a cycle [s].
        missed: Maximum share of missed cycles in a second [-].
        stale: Maximum share of samples in a second in which a joint is silent [-]: interpolating a tenth of
            the samples does not change estimates.
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
        """Maximum number of consecutive silent cycles, from the cycle time [s]."""
        return max(round(self.silence / cycle), self.least_silence)


class Watch:
    """All monitors at once.

    Args:
        robot: Robot with its limits.
        info: Metadata of the driver, with the cycle time.
        limits: Limits of the monitors.
        current: Maximum current, shape (n,) [A]; None for the current that makes the maximum torque.
    """

    def __init__(
        self, robot: Robot, info: Info, limits: WatchLimits, current: np.ndarray | None = None
    ) -> None:
        # A command is seen in the next cycle's sample at the earliest, however long the cycle is.
        self.tracking_error = monitors.TrackingError(max(round(limits.delay / info.cycle), 2))
        self._monitors = _monitors(robot, info, limits, current, self.tracking_error)

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        """The most severe reason to stop after this cycle, or None."""
        stop: Stop | None = None
        for monitor in self._monitors:
            stop = harder(stop, monitor.look(sample, sent))
        return stop


def _monitors(
    robot: Robot,
    info: Info,
    watch: WatchLimits,
    current: np.ndarray | None,
    tracking_error: monitors.TrackingError,
) -> tuple[monitors.Monitor, ...]:
    joints, limits, cycle, unit = robot.joints, robot.limits, info.cycle, robot.unit
    tracking, outside = np.full(robot.dof, watch.tracking), np.full(robot.dof, watch.outside)
    with np.errstate(divide="ignore"):
        by_torque = watch.effort * limits.torque / np.abs(robot.drive_gain)
    speed = watch.speed * np.maximum(limits.velocity, -limits.velocity_lower)
    tracking_cycles, effort = round(watch.tracking_time / cycle), round(watch.effort_time / cycle)
    return (
        monitors.DriveFault(),
        monitors.Silence(joints, watch.silent_cycles(cycle)),
        ControllerClock(cycle, watch.stall),
        monitors.Tracking(joints, tracking, tracking_cycles, tracking_error, unit),
        monitors.Outside(
            joints, limits.position_lower, limits.position_upper, outside, tracking_cycles, unit
        ),
        monitors.Speed(joints, speed, max(round(0.02 / cycle), 2), cycle, unit),
        monitors.Current(joints, by_torque if current is None else current, effort),
        monitors.Torque(joints, watch.effort * limits.torque, effort, unit),
        monitors.Temperature(joints, np.full(robot.dof, watch.temperature), round(1.0 / cycle), cycle),
        monitors.Stale(cycle, watch.stale, watch.least_silence),
        monitors.Lateness(cycle, watch.stall, watch.missed),
    )


class ControllerClock(Monitor):
    """Monitors the controller's clock, the time base of the recording: it must advance while samples come.

    `cycle` is the time between exchanges, `stall` the maximum time without an exchange [s].
    """

    def __init__(self, cycle: float, stall: float) -> None:
        window = max(round(CLOCK_WINDOW * stall / cycle), CLOCK_CYCLES)
        self._times = deque[tuple[int, int]](maxlen=window + 1)
        self._count = 0

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
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


class CommandCheck:
    """Checks each command against the two before it; an invalid command is not sent, and none is clamped.

    Args:
        joints: Names of the joints.
        limits: Limits of the robot; infinite limits are not checked.
        cycle: Time between commands [s].
        start: Position of the arm before the first command, shape (n,) [rad] or [m].
        window_lower: Lowest position that the controller accepts, shape (n,) [rad] or [m].
        window_upper: Highest position that the controller accepts, shape (n,) [rad] or [m].
        unit_of: Function that returns the unit of a joint.
    """

    def __init__(
        self,
        joints: Sequence[str],
        limits: Limits,
        cycle: float,
        start: np.ndarray,
        window_lower: np.ndarray | None = None,
        window_upper: np.ndarray | None = None,
        unit_of: UnitOf = revolute_unit,
    ) -> None:
        self._joints, self._unit_of = joints, unit_of
        lower = np.maximum(limits.position_lower, -np.inf if window_lower is None else window_lower)
        upper = np.minimum(limits.position_upper, np.inf if window_upper is None else window_upper)
        # An arm that stands outside its limits may move back inside, but not further out.
        self._lower, self._upper = (
            np.minimum(lower, start) - STEP_TOLERANCE,
            np.maximum(upper, start) + STEP_TOLERANCE,
        )
        self._step = SLACK * np.maximum(limits.velocity, -limits.velocity_lower) * cycle + STEP_TOLERANCE
        most = np.maximum(limits.acceleration, -limits.acceleration_lower)
        self._change = SLACK * most * cycle**2 + STEP_TOLERANCE
        self._cycle = cycle
        self._before, self._step_before = start, np.zeros(len(start))

    def look(self, command: Command) -> Stop | None:
        """The reason not to send a command; None if it is valid, and then the next is compared with it."""
        position = command.position
        if position.shape != self._before.shape or not np.isfinite(position).all():
            return self._stop("command", 0, float("nan"), 0.0, "rad", "is not a number")
        step = position - self._before
        violation = self._violation(position, step)
        if violation is None:
            self._before, self._step_before = position, step
        return violation

    def _violation(self, position: np.ndarray, step: np.ndarray) -> Stop | None:
        beyond = (position < self._lower) | (position > self._upper)
        if any_of(beyond):
            j = int(np.argmax(beyond))
            limit = self._lower[j] if position[j] < self._lower[j] else self._upper[j]
            return self._stop("command position", j, position[j], limit, "rad", "exceeds the limit of")
        if any_of(np.abs(step) > self._step):
            j = int(np.argmax(np.abs(step) - self._step))
            value, limit = step[j] / self._cycle, self._step[j] / self._cycle
            return self._stop("command velocity", j, value, limit, "rad/s", "exceeds the limit of")
        change = step - self._step_before
        if any_of(np.abs(change) > self._change):
            j = int(np.argmax(np.abs(change) - self._change))
            value, limit = change[j] / self._cycle**2, self._change[j] / self._cycle**2
            return self._stop("command acceleration", j, value, limit, "rad/s^2", "exceeds the limit of")
        return None

    def _stop(self, kind: str, joint: int, value: float, limit: float, unit: str, words: str) -> Stop:
        name, unit = self._joints[joint], self._unit_of(joint, unit)
        text = f"{name}: {kind} {value:.4g} {unit} {words}" + ("" if "not" in words else f" {limit:.4g}")
        return Stop(StopLevel.BRAKE, kind, text, name, float(value), float(limit), unit)
