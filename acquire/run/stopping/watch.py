"""Watch: all monitors of a run with their limits, and the final check of each command."""

from dataclasses import dataclass

import numpy as np

from exidyn.drivers import Command, Info, Sample, StopLevel
from exidyn.drivers.values import any_of
from exidyn.identification.arm.robot import Limits, Robot

from .history import History
from .monitors import (
    ControllerClock,
    JointMonitor,
    JointRule,
    Lateness,
    Monitor,
    Outside,
    Silence,
    Stale,
    drive_fault,
    mean_speed,
)
from .stop import Stop, harder

SPEED_WINDOW = 0.02
"""Averaging window of speeds, and time beyond the limit of the speed [s]."""
HOT_TIME = 1.0
"""Time beyond the limit of the temperature [s]: a single wrong reading stops nothing."""
SLACK = 1.05
"""Share of the velocity and acceleration limits that differences of commands may reach [-]: it allows for
rounding and for extremes between two samples."""
STEP_TOLERANCE = 1e-6
"""Step below which commands count as at rest [rad]: a tenth of an encoder step."""


@dataclass(frozen=True)
class WatchLimits:
    """Limits of the monitors while the arm moves."""

    # Maximum tracking error [rad] or [m]: two degrees, which is many times the lag of a sound drive and moves
    # the end of a 1 m link by 35 mm.
    tracking: float = 0.035
    tracking_time: float = 0.05  # maximum time beyond `tracking` or `outside` [s]
    # Maximum distance beyond the position limits [rad] or [m], independent of `tracking`: the lag of a sound
    # drive.
    outside: float = 0.035
    # Time within which a command takes effect [s]; motion in this time is not a tracking error.
    delay: float = 0.05
    effort: float = 1.2  # maximum torque over the torque limit, or current over the current that makes it [-]
    effort_time: float = 0.05  # maximum time beyond `effort` [s]; gears withstand short peaks
    temperature: float = 85.0  # maximum motor temperature [degC]: what most windings withstand, less a margin
    speed: float = 1.2  # maximum speed over the velocity limit [-]
    silence: float = 0.01  # maximum time for which a joint may be silent [s]
    least_silence: int = 5  # number of silent cycles that is allowed at any sampling rate
    stall: float = 0.05  # maximum time without a cycle [s]
    missed: float = 0.05  # maximum share of missed cycles in a second [-]
    # Maximum share of samples in a second in which a joint is silent [-]: interpolating a tenth of the
    # samples does not change estimates.
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
        # Samples and commands so far. A command is seen in the next cycle's sample at the earliest, however
        # long the cycle is.
        self.history = History(robot.dof, info.cycle, max(round(limits.delay / info.cycle), 2))
        rules = joint_rules(robot, info.cycle, limits, current)
        self._monitors: tuple[Monitor, ...] = (
            drive_fault,
            Silence(robot.joints, limits.silent_cycles(info.cycle)).look,
            ControllerClock(info.cycle, limits.stall).look,
            *(JointMonitor(rule, robot, info.cycle).look for rule in rules),
            Stale(info.cycle, limits.stale, limits.least_silence).look,
            Lateness(info.cycle, limits.stall, limits.missed).look,
        )

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        """The most severe reason to stop after this cycle, or None."""
        self.history.add(sample, sent)
        stop: Stop | None = None
        for monitor in self._monitors:
            stop = harder(stop, monitor(self.history))
        return stop


def joint_rules(
    robot: Robot, cycle: float, watch: WatchLimits, current: np.ndarray | None = None
) -> tuple[JointRule, ...]:
    """Table of the rules of joints, with `Watch`'s arguments; each row causes a controlled stop."""
    limits, every = robot.limits, np.ones(robot.dof)
    with np.errstate(divide="ignore"):
        by_torque = watch.effort * limits.torque / np.abs(robot.drive_gain)
    largest = by_torque if current is None else current
    fastest = np.maximum(limits.velocity, -limits.velocity_lower)
    window = max(round(SPEED_WINDOW / cycle), 2)
    outside = Outside(limits).distance
    rule, tolerated, effort_time = JointRule, watch.tracking_time, watch.effort_time
    return (
        # kind, quantity, limit of each joint, time beyond it [s], unit
        rule("tracking error", lambda h: h.tracking_error, watch.tracking * every, tolerated, "rad"),
        rule("position beyond its limits by", outside, watch.outside * every, tolerated, "rad"),
        rule("speed", lambda h: mean_speed(h, window, cycle), watch.speed * fastest, window * cycle, "rad/s"),
        rule("current", lambda h: np.abs(h.sample.current), largest, effort_time, "A"),
        rule("torque", lambda h: np.abs(h.sample.torque), watch.effort * limits.torque, effort_time, "N m"),
        rule(
            "temperature", lambda h: h.sample.temperature, watch.temperature * every, HOT_TIME, "degC", True
        ),
    )


class CommandCheck:
    """Checks each command against the two before it; an invalid command is not sent, and none is clamped.

    Args:
        robot: Robot, for names and units of the joints.
        limits: Limits of the robot; infinite limits are not checked.
        cycle: Time between commands [s].
        start: Position of the arm before the first command, shape (n,) [rad] or [m].
        window_lower: Lowest position that the controller accepts, shape (n,) [rad] or [m].
        window_upper: Highest position that the controller accepts, shape (n,) [rad] or [m].
    """

    def __init__(
        self,
        robot: Robot,
        limits: Limits,
        cycle: float,
        start: np.ndarray,
        window_lower: np.ndarray | None = None,
        window_upper: np.ndarray | None = None,
    ) -> None:
        self._robot = robot
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
        change, cycle = step - self._step_before, self._cycle
        for kind, motion, most, time, unit in (
            ("command velocity", step, self._step, cycle, "rad/s"),
            ("command acceleration", change, self._change, cycle**2, "rad/s^2"),
        ):
            excess = np.abs(motion) - most
            if any_of(excess > 0.0):
                j = int(np.argmax(excess))
                return self._stop(kind, j, motion[j] / time, most[j] / time, unit, "exceeds the limit of")
        return None

    def _stop(self, kind: str, joint: int, value: float, limit: float, unit: str, words: str) -> Stop:
        name, unit = self._robot.joints[joint], self._robot.unit(joint, unit)
        text = f"{name}: {kind} {value:.4g} {unit} {words}" + ("" if "not" in words else f" {limit:.4g}")
        return Stop(StopLevel.BRAKE, kind, text, name, float(value), float(limit), unit)
