"""Live log: what a run's cycles and events become in Rerun."""

from collections.abc import Sequence
from textwrap import wrap

import numpy as np
import rerun as rr

from exidyn.identify.pages.views.view_parts import GREY, JOINTS, TIMELINE, send

from ..run.pipe.frames import Cycle, Event
from ..run.pipe.run_head import RunHead
from .live_arm import LiveArm
from .live_layout import SHOWN, finite_limits, layout
from .residual import LiveResidual, Samples, joint_torque
from .scale import Scale

FRAMES = 50.0
"""Pictures of the arm a second [Hz]."""
LIMITS = 0.25
"""How often limits are drawn further [s]."""
COLUMNS = 64
"""Width of an event's text: what is longer goes on in a row of its own, since a view cuts rows off."""
INDENT = 12 * " "
"""Of such rows."""
RED = (255, 90, 60)
"""Of a stop, and of cycles that were skipped."""
FAINT = 110
"""Opacity of limits and commands, of 255: there, and not in the way."""
COLOURS = (*JOINTS, (213, 94, 0))
"""Of the joints, on dark ground and on light; from an eighth joint on they begin anew."""
LOOKS = {"stop": ("CRITICAL", RED), "late": ("WARN", JOINTS[1]), "warning": ("WARN", JOINTS[1])}
"""What Rerun calls an event of a kind, and its colour; the others are INFO and have the colour of text."""


class LiveLog:
    """Logs one run.

    Args:
        recording: Where to.
        head: What explains the run.
        first: The run's first cycles, from which the controller's own is learnt.
    """

    def __init__(self, recording: rr.RecordingStream, head: RunHead, first: Sequence[Cycle]) -> None:
        self._recording, self._model = recording, head.model
        self._start = first[0].host_time
        self._cycle = usual_cycle(first)
        self._effort = "current" if "current" in head.signals else "torque"
        self._residual = LiveResidual(head.model, self._cycle, head.payload)
        self._limits = finite_limits(head.model.robot, self._effort)
        self._colours = [COLOURS[joint % len(COLOURS)] for joint in range(head.model.robot.dof)]
        self._arm = LiveArm(recording, head.model, self._colours)
        self._scale = Scale(SHOWN)
        self._pictured = self._limited = -np.inf
        self._explain()

    def _explain(self) -> None:
        """Log all that stands still: names, colours and the layout."""
        robot, colours = self._model.robot, self._colours
        effort = f"{self._effort}/measured"
        for entity in ("position/measured", "tracking_error", "velocity/measured", effort, "residual"):
            self._lines(entity, robot.joints, colours, 1.8)
        # below what is measured, by name and so by width: a seam of grey is seen where they differ
        self._lines("position/commanded", ["commanded"] * robot.dof, [(*GREY, FAINT)] * robot.dof, 3.2)
        self._lines("lateness/late", ["late"], [JOINTS[0]], 1.5)
        points = rr.SeriesPoints(names="skipped", colors=RED, marker_sizes=4.0)
        self._recording.log("lateness/skipped", points, static=True)
        self._lines("residual/scale", ["scale"] * 2, [(*GREY, FAINT)] * 2, 1.0)
        for quantity, limits in self._limits.items():
            names = [f"limit of {robot.joints[joint]}" for joint in limits.joints]
            self._lines(
                f"{quantity}/limit", names, [(*colours[joint], FAINT) for joint in limits.joints], 1.0
            )
        self._recording.send_blueprint(layout(self._model, self._effort, self._residual.delay))

    def _lines(self, entity: str, names: Sequence[str], colours: Sequence[tuple], width: float) -> None:
        lines = rr.SeriesLines(names=list(names), colors=list(colours), widths=width)
        self._recording.log(entity, lines, static=True)

    def cycles(self, cycles: Sequence[Cycle]) -> None:
        """Log some cycles in order, one at least."""
        time = self._time(np.array([cycle.host_time for cycle in cycles]))
        position, command, current, torque = (
            np.array([cycle.array(name) for cycle in cycles])
            for name in ("position", "command_position", "current", "torque")
        )
        self._send("position/measured", time, position)
        self._send("position/commanded", time, command)
        self._send("tracking_error", time, 1e3 * (command - position))
        self._send(f"{self._effort}/measured", time, current if self._effort == "current" else torque)
        self._send_limits(time[[0, -1]])
        self._send_lateness(cycles, time)
        clock = 1e-9 * np.array([cycle.controller_time for cycle in cycles])
        self._send_residual(Samples(time, clock, position, joint_torque(self._model, current, torque)))
        self._move_arm(time, position)

    def _send_limits(self, ends: np.ndarray) -> None:
        if ends[1] >= self._limited + LIMITS:
            self._limited = ends[1]
            for quantity, limits in self._limits.items():
                self._send(f"{quantity}/limit", ends, np.tile(limits.values, (2, 1)))

    def _send_lateness(self, cycles: Sequence[Cycle], time: np.ndarray) -> None:
        self._send("lateness/late", time, 1e3 * np.array([cycle.lateness for cycle in cycles]))
        skipped = np.array([cycle.skipped for cycle in cycles])
        where = skipped > 0
        if where.any():
            self._send("lateness/skipped", time[where], 1e3 * self._cycle * skipped[where])

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
            if time[row] >= self._pictured + 1.0 / FRAMES:
                self._pictured = time[row]
                rows.append(row)
        if rows:
            self._arm.move(time[rows], position[rows])

    def event(self, event: Event) -> None:
        """Log what happened."""
        time = max(float(self._time(event.host_time)), 0.0)
        log_event(self._recording, ("events",), time, event.kind, event.text)

    def _time(self, host_time: np.ndarray | int) -> np.ndarray:
        """Time since the run's first cycle [s]."""
        return 1e-9 * np.asarray(host_time - self._start)

    def _send(self, entity: str, time: np.ndarray, values: np.ndarray) -> None:
        send(self._recording, entity, time, values)


def log_event(
    recording: rr.RecordingStream, origin: Sequence[str], time: float, kind: str, text: str
) -> None:
    """Log what happened at a time [s], in rows below an entity path, given by its parts."""
    level, colour = LOOKS.get(kind, ("INFO", None))
    recording.set_time(TIMELINE, duration=time)
    # an entity a kind, since one without a colour gets that of the one before
    entity = rr.new_entity_path([*origin, kind])
    for line in wrap(f"{time:.2f} s  {kind}: {text}", COLUMNS, subsequent_indent=INDENT):
        recording.log(entity, rr.TextLog(line, level=level, color=colour))


def usual_cycle(cycles: Sequence[Cycle]) -> float:
    """Time between cycles by the controller's clock, or by the host's where that stands still [s]."""
    whole = [1 + cycle.skipped for cycle in cycles[1:]]
    clocks = ([cycle.controller_time for cycle in cycles], [cycle.host_time for cycle in cycles])
    steps = (1e-9 * float(np.median(np.diff(clock) / whole)) for clock in clocks if whole)
    return next((step for step in steps if step > 0.0), 1e-3)
