"""View of recordings: one tab per run with measured signals, residuals of the model, and the arm."""

from collections.abc import Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identification.recordings.recording import EFFORT, Recording, Signal

from ..terminal.recording_text import describe
from .parts import (
    FAINT,
    FRAMES,
    GRAY,
    Arm,
    arm_name,
    arm_view,
    entity,
    event_list,
    joint_colors,
    log_event,
    log_lines,
    log_markdown,
    plot,
    screen,
)
from .residual import LiveResidual, Samples, joint_torque
from .viewers import View

CHUNK = 2000
"""Number of samples whose regressor is in memory at once: a few megabytes."""
MEASURED = {
    "position": "position",
    "velocity": "velocity",
    "current": "current [A]",
    "torque": "torque",
    "temperature": "temperature [°C]",
}
"""Titles of plots, by signal."""


def recording_view(recordings: Sequence[Recording]) -> View:
    """A view of runs, whose names must differ."""

    def log(stream: rr.RecordingStream) -> None:
        for recording in recordings:
            _log_run(stream, recording)

    tabs = [_tab(recording) for recording in recordings]
    return View("recording", log, screen(rrb.Tabs(*tabs, active_tab=0) if len(tabs) > 1 else tabs[0]))


def _tab(recording: Recording) -> rrb.Container:
    """Plots on the left; the arm, events and contents on the right."""
    name, revolute = recording.name, bool(recording.robot.revolute.all())
    angle, small = ("rad", "mrad") if revolute else ("rad, m", "mrad, mm")
    gray = ", commanded in gray" if "command" in recording.signals else ""
    force = ", ".join(dict.fromkeys(recording.robot.units("N m")))
    units = {"position": f"{gray} [{angle}]", "velocity": f" [{angle}/s]", "torque": f" [{force}]"}
    plots = [
        plot(entity(name, signal), title + units.get(signal, ""))
        for signal, title in MEASURED.items()
        if signal in recording.signals or signal == "velocity"
    ]
    if "command" in recording.signals:
        plots.insert(1, plot(entity(name, "tracking error"), f"command minus position [{small}]"))
    if "link_position" in recording.signals:
        plots.append(plot(entity(name, "twist"), f"link minus motor encoder [{small}]"))
    plots.append(plot(entity(name, "residual"), f"residual of the recorded model [{force}]", legend=True))
    texts: list[rrb.View] = [rrb.TextDocumentView(origin=entity(name, "inside"), name="contents")]
    if recording.events:
        texts.insert(0, event_list(entity(name, "events")))
    arm = arm_view(recording.model, arm_name(name))
    beside = rrb.Vertical(arm, rrb.Tabs(*texts, active_tab=0), row_shares=[3, 2])
    grid = rrb.Grid(*plots, grid_columns=2)
    return rrb.Horizontal(grid, beside, column_shares=[5, 3], name=name)


def _log_run(stream: rr.RecordingStream, recording: Recording) -> None:
    """Log signals, residuals, events and the arm of a run."""
    name, signals, position = recording.name, recording.signals, recording.signals["position"]
    joints, colors = recording.robot.joints, joint_colors(recording.robot.dof)

    def log(signal: Signal, *parts: str) -> None:
        log_lines(stream, entity(name, *parts), joints, colors, signal.time, signal.values)

    if "command" in signals:
        # below the measured lines, by name and so by width: a gray edge shows where they differ
        path, command = entity(name, "position", "commanded"), signals["command"]
        gray = [(*GRAY, FAINT)] * len(joints)
        log_lines(stream, path, joints, gray, command.time, command.values, 3.2)
    for signal, title in (("command", "tracking error"), ("link_position", "twist")):
        if signal in signals:
            difference = _at(signals[signal], position.time) - position.values
            log(Signal(position.time, 1e3 * difference), title)
    for signal in MEASURED:
        if signal in signals:
            log(signals[signal], signal, "measured")
    velocity, residual = _velocity_and_residual(recording)
    log(residual, "residual")
    if "velocity" not in signals:
        log(velocity, "velocity", "measured")
    for event in recording.events:
        log_event(stream, (name, "events"), event.time, event.kind, event.text)
    log_markdown(stream, entity(name, "inside"), f"```\n{describe(recording)}\n```")
    # the arm at the frame rate, where the positions of all joints are known
    arm = Arm(stream, recording.model, arm_name(name))
    step = max(round(1.0 / (FRAMES * position.period)), 1) if position.period else 1
    shown = position[np.arange(0, len(position), step)]
    shown = shown[np.isfinite(shown.values).all(axis=1)]
    if len(shown):
        arm.move(shown.time, shown.values)


def _at(signal: Signal, time: np.ndarray) -> np.ndarray:
    """A signal interpolated at times (t,), shape (t, n)."""
    if np.array_equal(signal.time, time):
        return signal.values
    return np.stack([np.interp(time, signal.time, column) for column in signal.values.T], axis=1)


def _velocity_and_residual(recording: Recording) -> tuple[Signal, Signal]:
    """Velocity, and measured minus nominal torque, computed as in the live view."""
    position = recording.signals["position"]
    unknown = np.full_like(position.values, np.nan)
    current, torque = (
        _at(recording.signals[name], position.time) if name in recording.signals else unknown
        for name in EFFORT
    )
    residual = LiveResidual(recording.model, position.period or 1e-3, recording.payload)
    samples = Samples(
        position.time, position.time, position.values, joint_torque(recording.model, current, torque)
    )
    pieces = [
        residual.add(Samples(*(array[start : start + CHUNK] for array in samples)))
        for start in range(0, len(position), CHUNK)
    ]
    stamp = np.concatenate([piece.stamp for piece in pieces])
    return (
        Signal(stamp, np.concatenate([piece.velocity for piece in pieces])),
        Signal(stamp, np.concatenate([piece.residual for piece in pieces])),
    )
