"""Watch: all monitors of a run, and their limits."""

from dataclasses import dataclass

import numpy as np

from exidyn.drivers import Command, Info, Sample
from exidyn.identify.arm.robot import Robot

from . import monitors
from .controller_clock import ControllerClock
from .stop import Stop, harder


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
        temperature: Of the motors [degC]; what most windings bear, less a margin.
        speed: Share of the velocity limits above which to stop [-].
        silence: How long a joint may be silent [s].
        least_silence: Cycles of silence that are borne at any rate.
        stall: Longest time without a cycle [s].
        missed: Share of a second's cycles that may be missed [-].
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

    def silent_cycles(self, cycle: float) -> int:
        """For how many cycles in a row a joint may be silent, given the time of one [s]."""
        return max(round(self.silence / cycle), self.least_silence)


class Watch:
    """All monitors at once.

    Args:
        robot: Its limits.
        info: Cycle of the controller.
        limits: What is in order.
        current: Largest current, shape (n,) [A], in place of what makes the largest torque.

    Attributes:
        tracking_error: Of the last sample.
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
        monitors.Temperature(joints, np.full(robot.dof, watch.temperature), round(1.0 / cycle)),
        monitors.Lateness(cycle, watch.stall, watch.missed),
    )
