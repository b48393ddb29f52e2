"""View of contact: external torques with thresholds, and the force on the arm; also live, as a process."""

import sys
from collections.abc import Callable
from typing import Literal

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identification.arm.newton_euler import flange_position
from exidyn.identification.contact.contact import Contact
from exidyn.identification.model import Model

from ..run.frames import EVENT, HEAD, SAMPLE, ContactHead, ContactRows, Event, read_event
from .live_log import live_plot
from .parts import (
    ARM,
    COLORS,
    FAINT,
    FRAMES,
    RED,
    TIMELINE,
    Arm,
    arm_view,
    base_frame,
    entity,
    event_list,
    log_event,
    plot,
    reach,
    screen,
    send,
    style_lines,
)
from .view_process import show_frames
from .viewers import View

EXTERNAL, FORCE, EVENTS = "external torque", "force", "contacts"
"""Parts of entity paths: torques by joint, the force and its arrow at the flange, and the contacts."""
LONGEST = 0.5
"""Length of the arrow of the largest force, over the reach of the arm [-]."""
LEAST = 0.1
"""Force that has an arrow of this length while no larger one was seen, over the weight of the arm [-]."""
GRAVITY = 9.81
"""Acceleration of gravity [m/s^2]."""


def contact_view(result: Contact, unit: str) -> View:
    """A view of external torques along a run; `unit` is that of the torques."""
    model, estimates = result.fit.model, result.estimates

    def log(stream: rr.RecordingStream) -> None:
        limit = np.full_like(estimates.torque, np.nan)
        if result.threshold is not None:
            limit = result.threshold.torque(estimates)
        rows = estimates.time, estimates.torque, limit, estimates.position, result.wrench[:, :3]
        ContactLog(stream, model).add(ContactRows(*rows))
        for alarm in result.alarms:
            joint = model.robot.joints[alarm.joint]
            log_event(stream, [EVENTS], alarm.start, "contact", f"{joint}, until {alarm.end:.2f} s")

    has_force, has_events = not result.fit.unscaled, bool(result.alarms)
    return View("contact", log, contact_layout(model, unit, has_force, has_events))


def contact_layout(
    model: Model,
    unit: str,
    has_force: bool,
    has_events: bool,
    make_plot: Callable[..., rrb.TimeSeriesView] = plot,
    play_state: Literal["paused", "following"] = "paused",
) -> rrb.Blueprint:
    """Plots of the torques and of the force on the left, the arm and the contacts on the right."""
    plots = [
        make_plot(entity(EXTERNAL, joint), f"{joint}: external torque [{unit}]", legend=not place)
        for place, joint in enumerate(model.robot.joints)
    ]
    if has_force:
        plots.append(
            make_plot(entity(FORCE), "force on the flange, in the axes of the base [N]", legend=True)
        )
    arm = arm_view(model, title="arm, and force on the flange" if has_force else "arm")
    beside = rrb.Vertical(arm, event_list(EVENTS), row_shares=[3, 1]) if has_events else arm
    return screen(rrb.Horizontal(rrb.Grid(*plots, grid_columns=2), beside), play_state)


class ContactLog:
    """Logs external torques, the moving arm and the force on its flange, in pieces of any length.

    The arrow of the `largest` force [N] has the length `LONGEST` until a larger one comes.
    """

    def __init__(self, stream: rr.RecordingStream, model: Model, largest: float = 0.0) -> None:
        self._stream, self._model, self._largest = stream, model, largest
        self._arm, self._data = Arm(stream, model), model.robot.kinematics.createData()
        self._frame = -np.inf
        for name in model.robot.joints:
            style_lines(stream, entity(EXTERNAL, name, "torque"), ["external torque"], [COLORS[0]])
            names, faint = ["threshold", "- threshold"], [(*RED, FAINT)] * 2
            style_lines(stream, entity(EXTERNAL, name, "threshold"), names, faint)
        style_lines(stream, entity(FORCE), ["x", "y", "z"], COLORS[:3])
        stream.log(entity(ARM, FORCE), rr.CoordinateFrame(base_frame(model)), static=True)
        stream.log(entity(ARM, FORCE), rr.Arrows3D.from_fields(colors=RED), static=True)

    def add(self, rows: ContactRows) -> None:
        """Log further rows, in the order of time."""
        for joint, name in enumerate(self._model.robot.joints):
            send(self._stream, entity(EXTERNAL, name, "torque"), rows.time, rows.torque[:, joint])
            limit = rows.limit[:, joint]
            if np.any(np.isfinite(limit)):
                band = np.stack([limit, -limit], axis=1)
                send(self._stream, entity(EXTERNAL, name, "threshold"), rows.time, band)
        frame = np.floor(rows.time * FRAMES)
        drawn = (np.diff(frame, prepend=self._frame) != 0.0) & np.all(np.isfinite(rows.position), axis=1)
        self._frame = frame[-1]
        if np.any(drawn):
            self._arm.move(rows.time[drawn], rows.position[drawn])
        known = np.all(np.isfinite(rows.force), axis=1)
        if np.any(known):
            send(self._stream, entity(FORCE), rows.time, rows.force)
            self._draw_arrows(ContactRows(*(part[known & drawn] for part in rows)))

    def _draw_arrows(self, rows: ContactRows) -> None:
        """An arrow at the flange for each row; the largest force so far has the length `LONGEST`."""
        if not len(rows.time):
            return
        robot = self._model.robot
        origins = np.array(
            [flange_position(robot.kinematics, robot.flange, row, self._data) for row in rows.position]
        )
        self._largest = max(self._largest, float(np.max(np.linalg.norm(rows.force, axis=1))))
        vectors = rows.force * LONGEST * reach(self._model) / (self._largest or 1.0)
        columns = rr.Arrows3D.columns(origins=origins, vectors=vectors)
        index = rr.TimeColumn(TIMELINE, duration=rows.time)
        self._stream.send_columns(entity(ARM, FORCE), indexes=[index], columns=columns)


def weight(model: Model) -> float:
    """Weight of the links by their nominal masses [N]."""
    return GRAVITY * float(sum(link.mass for link in model.robot.kinematics.inertias))


class ContactFrames:
    """Logs the frames of an arm that is watched, in batches."""

    def __init__(self, stream: rr.RecordingStream) -> None:
        self._stream = stream
        self._log: ContactLog | None = None
        self._samples: list[bytes] = []
        self._events: list[Event] = []

    def take(self, kind: bytes, body: bytes) -> None:
        if kind == HEAD:
            head = ContactHead.read(body)
            self._log = ContactLog(self._stream, head.model, LEAST * weight(head.model))
            layout = contact_layout(head.model, head.unit, head.force, True, live_plot, "following")
            self._stream.send_blueprint(layout)
        elif kind == SAMPLE:
            self._samples.append(body)
        elif kind == EVENT:
            self._events.append(read_event(body))

    def draw(self, last: bool) -> None:
        """Log what was taken since the last batch."""
        if self._log is not None and self._samples:
            self._log.add(ContactRows.read(self._samples))
        for event in self._events:
            log_event(self._stream, [EVENTS], 1e-9 * event.controller_time, event.kind, event.text)
        self._samples, self._events = [], []


if __name__ == "__main__":
    sys.exit(show_frames(sys.argv[1:], ContactFrames))
