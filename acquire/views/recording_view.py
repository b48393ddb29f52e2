"""View of recordings: a tab a run with what was measured, what the model leaves of it, and the arm."""

from collections.abc import Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identify.pages.views.view_arm import arm_view
from exidyn.identify.pages.views.view_parts import GREY, TIMELINE, send
from exidyn.identify.recordings.recording import EFFORT, Recording, Signal

from ..live.live_arm import LiveArm
from ..live.live_layout import EVENT_COLUMNS
from ..live.live_log import COLOURS, FAINT, FRAMES, log_event
from ..live.residual import LiveResidual, Samples, joint_torque
from ..terminal.recording_text import describe
from .screen import View

CHUNK = 2000
"""Samples whose regressor is held at once; a few megabytes."""
MEASURED = {
    "position": "position",
    "velocity": "velocity",
    "current": "current [A]",
    "torque": "torque",
    "temperature": "temperature [°C]",
}
"""Signal -> title of its plot."""


def recording_view(recordings: Sequence[Recording]) -> View:
    """A view of runs; their names must differ."""

    def log(stream: rr.RecordingStream) -> None:
        for recording in recordings:
            _log_run(stream, recording)

    tabs = [_tab(recording) for recording in recordings]
    layout = rrb.Tabs(*tabs, active_tab=0) if len(tabs) > 1 else tabs[0]
    panel = rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="paused")
    return View("recording", log, rrb.Blueprint(layout, panel, collapse_panels=True))


def _tab(recording: Recording) -> rrb.Container:
    """Plots on the left; the arm, what happened and what is inside on the right."""
    name, revolute = recording.name, bool(recording.robot.revolute.all())
    angle, small = ("rad", "mrad") if revolute else ("rad, m", "mrad, mm")
    grey = ", commanded in grey" if "command" in recording.signals else ""
    force = ", ".join(dict.fromkeys(recording.robot.units("N m")))
    units = {"position": f"{grey} [{angle}]", "velocity": f" [{angle}/s]", "torque": f" [{force}]"}
    plots = [
        _plot(name, signal, title + units.get(signal, ""))
        for signal, title in MEASURED.items()
        if signal in recording.signals or signal == "velocity"
    ]
    if "command" in recording.signals:
        plots.insert(1, _plot(name, "tracking error", f"command less position [{small}]"))
    if "link_position" in recording.signals:
        plots.append(_plot(name, "twist", f"second encoder less motor's [{small}]"))
    plots.append(_plot(name, "residual", f"torque that the model inside leaves [{force}]"))
    texts: list[rrb.View | rrb.Container] = [
        rrb.TextDocumentView(origin=_entity(name, "inside"), name="what is inside")
    ]
    if recording.events:
        texts.insert(0, rrb.TextLogView(origin=_entity(name, "events"), name="events", columns=EVENT_COLUMNS))
    beside = rrb.Vertical(
        arm_view(recording.model, _arm(name)), rrb.Tabs(*texts, active_tab=0), row_shares=[3, 2]
    )
    grid = rrb.Grid(*plots, grid_columns=2)
    return rrb.Horizontal(grid, beside, column_shares=[5, 3], name=name)


def _plot(run: str, quantity: str, title: str) -> rrb.TimeSeriesView:
    """A plot; the first has the legend of the joints for all."""
    legend = rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=quantity == "residual")
    return rrb.TimeSeriesView(origin=_entity(run, quantity), name=title, plot_legend=legend)


def _entity(*parts: str) -> str:
    """Entity path of parts that may hold any sign."""
    return str(rr.new_entity_path(list(parts)))


def _arm(run: str) -> str:
    """Name of a run's arm: one part of an entity path, and the prefix of its link frames."""
    return f"arm in {run}"


def _log_run(stream: rr.RecordingStream, recording: Recording) -> None:
    """Everything about one run."""
    name, signals, position = recording.name, recording.signals, recording.signals["position"]
    colours = [COLOURS[joint % len(COLOURS)] for joint in range(recording.robot.dof)]
    if "command" in signals:
        # below what is measured, by name and so by width: a seam of grey is seen where they differ
        grey = [(*GREY, FAINT)] * recording.robot.dof
        _log_lines(stream, _entity(name, "position", "commanded"), recording, signals["command"], grey, 3.2)
        error = Signal(position.time, 1e3 * (_at(signals["command"], position.time) - position.values))
        _log_lines(stream, _entity(name, "tracking error"), recording, error, colours)
    if "link_position" in signals:
        twist = Signal(position.time, 1e3 * (_at(signals["link_position"], position.time) - position.values))
        _log_lines(stream, _entity(name, "twist"), recording, twist, colours)
    for signal in MEASURED:
        if signal in signals:
            _log_lines(stream, _entity(name, signal, "measured"), recording, signals[signal], colours)
    velocity, residual = _derived(recording)
    _log_lines(stream, _entity(name, "residual"), recording, residual, colours)
    if "velocity" not in signals:
        _log_lines(stream, _entity(name, "velocity", "measured"), recording, velocity, colours)
    _log_arm(stream, recording, colours)
    for event in recording.events:
        log_event(stream, (name, "events"), event.time, event.kind, event.text)
    words = f"```\n{describe(recording)}\n```"
    text = rr.TextDocument(words, media_type="text/markdown")
    stream.log(_entity(name, "inside"), text, static=True)


def _log_lines(
    stream: rr.RecordingStream,
    entity: str,
    recording: Recording,
    signal: Signal,
    colours: Sequence[tuple],
    width: float = 1.5,
) -> None:
    """One line a joint."""
    lines = rr.SeriesLines(names=list(recording.robot.joints), colors=list(colours), widths=width)
    stream.log(entity, lines, static=True)
    send(stream, entity, signal.time, signal.values)


def _at(signal: Signal, time: np.ndarray) -> np.ndarray:
    """A signal at other times, shape (t, n)."""
    if np.array_equal(signal.time, time):
        return signal.values
    return np.stack([np.interp(time, signal.time, column) for column in signal.values.T], axis=1)


def _derived(recording: Recording) -> tuple[Signal, Signal]:
    """Velocity, and measured torque less that of the model, by the arithmetic of the live view."""
    position = recording.signals["position"]
    nothing = np.full_like(position.values, np.nan)
    current, torque = (
        _at(recording.signals[name], position.time) if name in recording.signals else nothing
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


def _log_arm(stream: rr.RecordingStream, recording: Recording, colours: Sequence[tuple]) -> None:
    """The arm where all of its joints are known, as often as the eye wants it."""
    position = recording.signals["position"]
    step = max(round(1.0 / (FRAMES * position.period)), 1) if position.period else 1
    shown = position[np.arange(0, len(position), step)]
    shown = shown[np.isfinite(shown.values).all(axis=1)]
    arm = LiveArm(stream, recording.model, colours, _arm(recording.name))
    if len(shown):
        arm.move(shown.time, shown.values)
