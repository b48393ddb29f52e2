"""View of a diagnosis: a tab a run with the moments in which each finding shows, residuals, and the arm."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identification.arm.newton_euler import link_frames
from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.findings.evidence import Trace
from exidyn.identification.diagnosis.findings.quantities import SLIDING, TURNING
from exidyn.identification.document.markdown import section_markdown
from exidyn.identification.pages.diagnosis_document import diagnosis_document
from exidyn.identification.pages.shown import Shown

from ..files.diagnosis_files import Traces
from ..files.given_runs import role_words
from .parts import (
    GREY,
    TIMELINE,
    Arm,
    arm_name,
    arm_view,
    entity,
    joint_colours,
    log_lines,
    log_markdown,
    plot,
    reach,
    screen,
)
from .suspects import Suspect, lasting, suspects
from .viewers import View

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


def diagnosis_view(shown: Shown, traces: Traces | None) -> View:
    """A view of a diagnosis and of the samples behind it; without them, of words only."""
    diagnosis = shown.diagnosis
    known = [] if traces is None else suspects(diagnosis, traces)
    sections = [section for section in diagnosis_document(shown).sections if section.blocks]
    texts = {section.anchor: section_markdown(section) for section in sections}

    def log(stream: rr.RecordingStream) -> None:
        for name, words in texts.items():
            log_markdown(stream, f"texts/{name}", words)
        if traces is not None:
            for trace in traces.traces:
                _log_run(stream, diagnosis, traces, trace, known)

    found = rrb.Vertical(
        rrb.TextDocumentView(origin="texts/verdict", name="verdict"),
        rrb.Tabs(
            *(
                rrb.TextDocumentView(origin=f"texts/{section.anchor}", name=section.title)
                for section in sections
                if section.anchor not in ("verdict", "joints")
            ),
            active_tab=0,
        ),
    )
    layout: rrb.Container = found
    if traces is not None and traces.traces:
        runs = [_tab(diagnosis, traces, trace, known) for trace in traces.traces]
        layout = rrb.Horizontal(rrb.Tabs(*runs, active_tab=0), found, column_shares=[3, 1])
    return View("diagnosis", log, screen(layout))


def _tab(diagnosis: Diagnosis, traces: Traces, trace: Trace, known: list[Suspect]) -> rrb.Container:
    """Plots on the left, the arm and the list of moments on the right."""
    views: list[rrb.View | rrb.Container] = []
    for suspect in known[:MOST]:
        unit = TURNING if traces.model.robot.revolute[suspect.joint] else SLIDING
        title = f"{suspect.name}: residual of {diagnosis.joints[suspect.joint]} [{unit}]"
        views.append(_plot(trace, suspect.name, title, legend=not views))
    scale = "over noise" if diagnosis.noise_measured_at_rest else "[N m] or [N]"
    every = [_plot(trace, which, f"every joint, {which}, {scale}", True) for which in ("after", "before")]
    views += [rrb.Tabs(*every, active_tab=0)] if known else every[::-1]
    arm = arm_view(traces.model, arm_name(trace.name))
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
    return plot(_entity(trace, "residuals", what), title, legend)


def _entity(trace: Trace, *parts: str) -> str:
    """Entity path below a run."""
    return entity("runs", trace.name, *parts)


def _log_run(
    stream: rr.RecordingStream, diagnosis: Diagnosis, traces: Traces, trace: Trace, known: list[Suspect]
) -> None:
    """Everything about one run."""
    measured = diagnosis.noise_measured_at_rest
    colours = joint_colours(len(traces.noise))
    for which in ("before", "after"):
        residual = getattr(trace, which) / (traces.noise if measured else 1.0)
        shown = lasting(trace.time, residual, trace.weight)
        path = _entity(trace, "residuals", which)
        log_lines(stream, path, diagnosis.joints, colours, trace.time, shown, 1.2)
    Arm(stream, traces.model, arm_name(trace.name)).move(trace.time, trace.position)
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
        path = _entity(trace, "residuals", suspect.name, name)
        shown = np.where(slides, values, np.nan)
        log_lines(stream, path, [name[2:]], [colour], trace.time, shown, width)
    if noise is not None:
        path, levels = _entity(trace, "residuals", suspect.name, "3 noise"), [[noise, -noise]] * 2
        ends = trace.time[[0, -1]]
        log_lines(stream, path, ["noise", "noise"], [FAINT, FAINT], ends, np.array(levels), 1.0)


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
    height = BELOW * float(np.max(np.abs(suspect.before(trace) * trace.weight[:, suspect.joint])))
    within = np.zeros(len(trace.time), bool)
    for moment in found:
        within |= (trace.time >= moment.begin) & (trace.time <= moment.end)
    shown = np.where(within, height, np.nan)
    log_lines(stream, bar, ["shows most"], [suspect.colour], trace.time, shown, 7.0)


def _resize(stream: rr.RecordingStream, ball: str, time: float, radius: float) -> None:
    """How large a ball is from a time [s] on [m]."""
    stream.set_time(TIMELINE, duration=time)
    stream.log(ball, rr.Points3D.from_fields(radii=[radius]))


def _log_ball(
    stream: rr.RecordingStream, traces: Traces, trace: Trace, suspect: Suspect
) -> tuple[str, float]:
    """A ball in the joint's frame, and how large it is when it is seen [m]."""
    name = arm_name(trace.name)
    path = entity(name, "marks", suspect.name)
    frame = f"{name}/{link_frames(traces.model.robot.kinematics)[suspect.joint].child}"
    stream.log(path, rr.CoordinateFrame(frame), static=True)
    ball = rr.Points3D.from_fields(positions=[[0.0, 0.0, 0.0]], colors=[suspect.colour])
    stream.log(path, ball, static=True)
    return path, MARK * reach(traces.model)
