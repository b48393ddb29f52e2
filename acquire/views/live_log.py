"""Live log: logs the cycles and events of a run to Rerun, with one plot per quantity and its limits."""

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identification.arm.robot import Robot
from exidyn.identification.model import Model

from ..run.frames import Cycle, Event
from ..run.recorder import RunHead
from .parts import (
    COLORS,
    FAINT,
    FRAMES,
    GRAY,
    RED,
    TIMELINE,
    Arm,
    arm_view,
    event_list,
    joint_colors,
    log_event,
    plot,
    screen,
    send,
    style_lines,
)
from .residual import LiveResidual, Samples, Scale, joint_torque

SHOWN = 15.0
"""Time span of the plots [s]."""
LIMITS = 0.25
"""Time between extensions of the lines of limits [s]."""


class LiveLog:
    """Logs a run, described by its head; its first cycles determine the controller's cycle time."""

    def __init__(self, recording: rr.RecordingStream, head: RunHead, first: Sequence[Cycle]) -> None:
        self._recording, self._model = recording, head.model
        self._send = partial(send, recording)
        self._start = first[0].host_time
        self._cycle = usual_cycle(first)
        self._effort = "current" if "current" in head.signals else "torque"
        self._residual = LiveResidual(head.model, self._cycle, head.payload)
        self._limits = finite_limits(head.model.robot, self._effort)
        self._arm = Arm(recording, head.model)
        self._scale = Scale(SHOWN)
        self._last_pose = self._last_limits = -np.inf
        self._log_styles()
        recording.send_blueprint(_layout(head.model, self._effort, self._residual.delay))

    def _log_styles(self) -> None:
        """Log names and colors of all lines."""
        robot, recording, faint = self._model.robot, self._recording, (*GRAY, FAINT)
        colors = joint_colors(robot.dof)
        effort = f"{self._effort}/measured"
        for path in ("position/measured", "tracking_error", "velocity/measured", effort, "residual"):
            style_lines(recording, path, robot.joints, colors, 1.8)
        # below the measured lines, by name and so by width: a gray edge shows where they differ
        style_lines(recording, "position/commanded", ["commanded"] * robot.dof, [faint] * robot.dof, 3.2)
        style_lines(recording, "lateness/late", ["late"], COLORS[:1])
        points = rr.SeriesPoints(names="skipped", colors=RED, marker_sizes=4.0)
        recording.log("lateness/skipped", points, static=True)
        style_lines(recording, "residual/scale", ["scale"] * 2, [faint] * 2, 1.0)
        for quantity, limits in self._limits.items():
            names = [f"limit of {robot.joints[joint]}" for joint in limits.joints]
            color = [(*colors[joint], FAINT) for joint in limits.joints]
            style_lines(recording, f"{quantity}/limit", names, color, 1.0)

    def cycles(self, cycles: Sequence[Cycle]) -> None:
        """Log one or more cycles, in order."""
        time = self._time(np.array([cycle.host_time for cycle in cycles]))
        position, command, current, torque = (
            np.array([cycle.array(name) for cycle in cycles])
            for name in ("position", "command_position", "current", "torque")
        )
        self._send("position/measured", time, position)
        self._send("position/commanded", time, command)
        self._send("tracking_error", time, 1e3 * (command - position))
        self._send(f"{self._effort}/measured", time, current if self._effort == "current" else torque)
        if time[-1] >= self._last_limits + LIMITS:
            self._last_limits = time[-1]
            for quantity, limits in self._limits.items():
                self._send(f"{quantity}/limit", time[[0, -1]], np.tile(limits.values, (2, 1)))
        self._send("lateness/late", time, 1e3 * np.array([cycle.lateness for cycle in cycles]))
        skipped = np.array([cycle.skipped for cycle in cycles])
        where = skipped > 0
        if where.any():
            self._send("lateness/skipped", time[where], 1e3 * self._cycle * skipped[where])
        clock = 1e-9 * np.array([cycle.controller_time for cycle in cycles])
        self._send_residual(Samples(time, clock, position, joint_torque(self._model, current, torque)))
        self._move_arm(time, position)

    def _send_residual(self, samples: Samples) -> None:
        torques = self._residual.add(samples)
        if len(torques.stamp):
            self._send("velocity/measured", torques.stamp, torques.velocity)
            self._send("residual", torques.stamp, torques.residual)
            mark = self._scale.add(torques.stamp, torques.residual)
            self._send("residual/scale", torques.stamp[-1:], np.array([[-mark, mark]]))

    def _move_arm(self, time: np.ndarray, position: np.ndarray) -> None:
        rows = []
        for row in np.flatnonzero(np.isfinite(position).all(axis=1)):
            if time[row] >= self._last_pose + 1.0 / FRAMES:
                self._last_pose = time[row]
                rows.append(row)
        if rows:
            self._arm.move(time[rows], position[rows])

    def event(self, event: Event) -> None:
        """Log an event."""
        time = max(float(self._time(event.host_time)), 0.0)
        log_event(self._recording, ["events"], time, event.kind, event.text)

    def _time(self, host_time: np.ndarray | int) -> np.ndarray:
        """Time since the run's first cycle [s]."""
        return 1e-9 * np.asarray(host_time - self._start)


def usual_cycle(cycles: Sequence[Cycle]) -> float:
    """Median time between cycles by the controller's clock, or by the host's if that stands still [s]."""
    counts = [1 + cycle.skipped for cycle in cycles[1:]]
    clocks = ([cycle.controller_time for cycle in cycles], [cycle.host_time for cycle in cycles])
    steps = (1e-9 * float(np.median(np.diff(clock) / counts)) for clock in clocks if counts)
    return next((step for step in steps if step > 0.0), 1e-3)


class DrawnLimits(NamedTuple):
    """Finite limits of a quantity; lower limits come first."""

    joints: np.ndarray  # joint of each limit, shape (k,)
    values: np.ndarray  # shape (k,), in the unit of the quantity


def finite_limits(robot: Robot, effort: str) -> dict[str, DrawnLimits]:
    """Finite limits by quantity; those of effort "current" are the currents that make the maximum torque."""
    limits = robot.limits
    largest = limits.torque / np.abs(robot.drive_gain) if effort == "current" else limits.torque
    bounds = {
        "position": np.concatenate([limits.position_lower, limits.position_upper]),
        "velocity": np.concatenate([limits.velocity_lower, limits.velocity]),
        effort: np.concatenate([-largest, largest]),
    }
    finite = {quantity: np.flatnonzero(np.isfinite(values)) for quantity, values in bounds.items()}
    return {
        quantity: DrawnLimits(rows % robot.dof, bounds[quantity][rows])
        for quantity, rows in finite.items()
        if len(rows)
    }


def _layout(model: Model, effort: str, delay: float) -> rrb.Blueprint:
    """Plots on the left, the arm and events on the right; velocity and residual are `delay` [s] old."""
    revolute = bool(model.robot.revolute.all())
    angle, small = ("rad", "mrad") if revolute else ("rad, m", "mrad, mm")
    torque = "/".join(dict.fromkeys(model.robot.units("N m")))
    age = f"{1e3 * delay:.0f} ms old"
    plots = rrb.Grid(
        live_plot("position", f"position, commanded in gray [{angle}]"),
        live_plot("tracking_error", f"tracking error [{small}]", legend=True),
        live_plot("velocity", f"velocity, {age} [{angle}/s]"),
        live_plot(effort, f"{effort} [{'A' if effort == 'current' else torque}]"),
        live_plot("residual", f"residual torque, {age} [{torque}]"),
        live_plot("lateness", "lateness of cycles [ms]", legend=True),
        grid_columns=2,
    )
    beside = rrb.Vertical(arm_view(model), event_list("events"), row_shares=[3, 2])
    return screen(rrb.Horizontal(plots, beside, column_shares=[5, 3]), "following")


def live_plot(origin: str, name: str, legend: bool = False) -> rrb.TimeSeriesView:
    """A plot of the last `SHOWN` seconds; see `plot`."""
    past = rr.VisibleTimeRange(
        TIMELINE,
        start=rr.TimeRangeBoundary.cursor_relative(seconds=-SHOWN),
        end=rr.TimeRangeBoundary.cursor_relative(),
    )
    return plot(origin, name, legend, time_ranges=[past])
