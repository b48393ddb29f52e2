"""View of a diagnosis: a tab a run with the moments in which each finding shows, residuals, and the arm."""

from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identify.arm.link_frames import link_frames
from exidyn.identify.diagnosis.findings.quantities import SLIDING, TURNING
from exidyn.identify.diagnosis.findings.trace import Trace
from exidyn.identify.pages.views.view_arm import arm_view
from exidyn.identify.pages.views.view_parts import GREY, TIMELINE, send

from ..files.names import role_words
from ..files.traces_file import Traces
from ..live.live_arm import LiveArm
from ..live.live_log import COLOURS
from .diagnosis_words import budget_markdown, parameters_markdown, residuals_markdown, verdict_markdown
from .moments import lasting
from .screen import View
from .suspects import Suspect, suspects

BEFORE, AFTER = (213, 94, 0), (86, 180, 233)
"""Colours of residuals, as in the report: vermilion without a finding, blue with it."""
FAINT = (*GREY, 150)
"""Of the noise, there and not in the way."""
BELOW = -1.12
"""Height of the bar of moments, as a share of the largest residual: below all of it."""
MARK = 0.05
"""Radius of the ball on a joint in the moments of its finding, as a share of the arm's reach."""
MOST = 3
"""Plots of findings on one screen; the list of moments and the table have all."""
COLUMNS = rrb.TextLogColumns(
    timeline_columns=[rrb.encodings.TimelineColumn(TIMELINE, visible=True)], text_log_columns=["body"]
)
"""Of the list of moments: the time, on which one clicks to go there, and the words."""
TEXTS = {
    "budget": budget_markdown,
    "verdict": verdict_markdown,
    "parameters": parameters_markdown,
    "residuals": residuals_markdown,
}


def diagnosis_view(table: dict[str, Any], traces: Traces | None) -> View:
    """A view of a diagnosis.

    Args:
        table: Of diagnosis.json.
        traces: The samples behind it; without them there are words only.
    """
    known = [] if traces is None else suspects(table, traces)
    texts = {name: words(table) for name, words in TEXTS.items()}

    def log(stream: rr.RecordingStream) -> None:
        for name, words in texts.items():
            text = rr.TextDocument(words, media_type="text/markdown")
            stream.log(f"texts/{name}", text, static=True)
        if traces is not None:
            for trace in traces.traces:
                _log_run(stream, table, traces, trace, known)

    found = rrb.Vertical(
        rrb.TextDocumentView(origin="texts/verdict", name="verdict"),
        rrb.Tabs(
            rrb.TextDocumentView(origin="texts/budget", name="where the misfit goes"),
            rrb.TextDocumentView(origin="texts/parameters", name="parameters"),
            rrb.TextDocumentView(origin="texts/residuals", name="residuals held out"),
            active_tab=0,
        ),
    )
    layout: rrb.Container = found
    if traces is not None and traces.traces:
        runs = [_tab(table, traces, trace, known) for trace in traces.traces]
        layout = rrb.Horizontal(rrb.Tabs(*runs, active_tab=0), found, column_shares=[3, 1])
    panel = rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="paused")
    return View("diagnosis", log, rrb.Blueprint(layout, panel, collapse_panels=True))


def _tab(table: dict[str, Any], traces: Traces, trace: Trace, known: list[Suspect]) -> rrb.Container:
    """Plots on the left, the arm and the list of moments on the right."""
    views: list[rrb.View | rrb.Container] = []
    for suspect in known[:MOST]:
        unit = TURNING if traces.model.robot.revolute[suspect.joint] else SLIDING
        title = f"{suspect.name}: residual of {table['joints'][suspect.joint]} [{unit}]"
        views.append(_plot(trace, suspect.name, title, legend=not views))
    scale = "over noise" if table.get("noise_measured_at_rest", True) else "[N m] or [N]"
    every = [_plot(trace, which, f"every joint, {which}, {scale}", True) for which in ("after", "before")]
    views += [rrb.Tabs(*every, active_tab=0)] if known else every[::-1]
    arm = arm_view(traces.model, _arm(trace))
    beside: rrb.View | rrb.Container = arm
    if known:
        times = rrb.TextLogView(
            origin=_entity(trace, "moments"), name="moments: a click on a time goes there", columns=COLUMNS
        )
        beside = rrb.Vertical(arm, times, row_shares=[3, 2])
    role = role_words(trace.role)
    name = f"{trace.name} ({role})" if role else trace.name
    return rrb.Horizontal(rrb.Vertical(*views), beside, column_shares=[3, 2], name=name)


def _plot(trace: Trace, what: str, title: str, legend: bool) -> rrb.TimeSeriesView:
    where = rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=legend)
    return rrb.TimeSeriesView(origin=_entity(trace, "residuals", what), name=title, plot_legend=where)


def _entity(trace: Trace, *parts: str) -> str:
    """Entity path below a run, whose own name may hold any sign."""
    return str(rr.new_entity_path(["runs", trace.name, *parts]))


def _arm(trace: Trace) -> str:
    """Name of a run's arm: one part of an entity path, and the prefix of its link frames."""
    return f"arm in {trace.name}"


def _log_run(
    stream: rr.RecordingStream, table: dict[str, Any], traces: Traces, trace: Trace, known: list[Suspect]
) -> None:
    """Everything about one run."""
    measured = bool(table.get("noise_measured_at_rest", True))
    colours = [COLOURS[joint % len(COLOURS)] for joint in range(len(traces.noise))]
    for which in ("before", "after"):
        entity = _entity(trace, "residuals", which)
        lines = rr.SeriesLines(names=list(table["joints"]), colors=colours, widths=1.2)
        stream.log(entity, lines, static=True)
        level = traces.noise if measured else np.ones(len(traces.noise))
        shown = getattr(trace, which) / level
        send(stream, entity, trace.time, lasting(trace.time, shown, trace.weight))
    LiveArm(stream, traces.model, colours, _arm(trace)).move(trace.time, trace.position)
    for suspect in known:
        _log_residual(stream, trace, suspect, float(traces.noise[suspect.joint]) if measured else None)
        _log_moments(stream, traces, trace, suspect, measured)


def _log_residual(stream: rr.RecordingStream, trace: Trace, suspect: Suspect, noise: float | None) -> None:
    """What is left of a joint before a finding and after, the noise beside it where it was measured."""
    slides = trace.weight[:, suspect.joint] > 0
    with_it = trace.after[:, suspect.joint]
    # a line on a line hides it: the wider ones are drawn first, by their names
    lines = {"1 before": (suspect.before(trace), BEFORE, 2.2), "2 after": (with_it, AFTER, 1.4)}
    for name, (values, colour, width) in lines.items():
        entity = _entity(trace, "residuals", suspect.name, name)
        stream.log(entity, rr.SeriesLines(names=name[2:], colors=colour, widths=width), static=True)
        send(stream, entity, trace.time, np.where(slides, values, np.nan))
    if noise is None:
        return
    entity = _entity(trace, "residuals", suspect.name, "3 noise")
    stream.log(entity, rr.SeriesLines(names=["noise", "noise"], colors=[FAINT] * 2, widths=1.0), static=True)
    send(stream, entity, trace.time[[0, -1]], np.array([[noise, -noise]] * 2))


def _log_moments(
    stream: rr.RecordingStream, traces: Traces, trace: Trace, suspect: Suspect, measured: bool
) -> None:
    """When it shows: a bar below its residual, rows of text, and a ball on the joint."""
    found = suspect.moments(trace, traces.noise)
    noise = 0.0 if measured else float(traces.noise[suspect.joint])
    ball, radius = _log_ball(stream, traces, trace, suspect)
    _resize(stream, ball, float(trace.time[0]), 0.0)
    for moment in found:
        _resize(stream, ball, moment.begin, radius)
        words = suspect.sentence(moment, trace, traces.model.robot, noise)
        row = rr.TextLog(words, color=suspect.colour)
        stream.log(_entity(trace, "moments", suspect.name), row)
        _resize(stream, ball, moment.end, 0.0)
    bar = _entity(trace, "residuals", suspect.name, "4 moments")
    looks = rr.SeriesLines(names="shows most", colors=suspect.colour, widths=7.0)
    stream.log(bar, looks, static=True)
    height = BELOW * float(np.max(np.abs(suspect.before(trace) * trace.weight[:, suspect.joint])))
    within = np.zeros(len(trace.time), bool)
    for moment in found:
        within |= (trace.time >= moment.begin) & (trace.time <= moment.end)
    send(stream, bar, trace.time, np.where(within, height, np.nan))


def _resize(stream: rr.RecordingStream, ball: str, time: float, radius: float) -> None:
    """How large a ball is from a time [s] on [m]."""
    stream.set_time(TIMELINE, duration=time)
    stream.log(ball, rr.Points3D.from_fields(radii=[radius]))


def _log_ball(
    stream: rr.RecordingStream, traces: Traces, trace: Trace, suspect: Suspect
) -> tuple[str, float]:
    """A ball in the joint's frame, and how large it is when it is seen [m]."""
    kinematics = traces.model.robot.kinematics
    reach = float(sum(np.linalg.norm(place.translation) for place in kinematics.jointPlacements)) or 1.0
    name = _arm(trace)
    entity = str(rr.new_entity_path([name, "marks", suspect.name]))
    frame = f"{name}/{link_frames(kinematics)[suspect.joint].child}"
    stream.log(entity, rr.CoordinateFrame(frame), static=True)
    ball = rr.Points3D.from_fields(positions=[[0.0, 0.0, 0.0]], colors=[suspect.colour])
    stream.log(entity, ball, static=True)
    return entity, MARK * reach
