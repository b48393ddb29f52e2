"""View of a diagnosis: one tab per run with the moments of each finding, residuals, and the arm."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identification.arm.newton_euler import link_frames
from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.findings.evidence import Trace
from exidyn.identification.diagnosis.findings.quantities import SLIDING, TURNING
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.document.text import section_markdown
from exidyn.identification.model import Model
from exidyn.identification.pages.diagnosis_document import diagnosis_document
from exidyn.identification.pages.shown import Shown

from .parts import (
    GRAY,
    TIMELINE,
    Arm,
    arm_name,
    arm_view,
    entity,
    joint_colors,
    log_lines,
    log_markdown,
    plot,
    reach,
    screen,
)
from .suspects import Suspect, suspects, windowed_rms
from .viewers import View

BEFORE, AFTER = (213, 94, 0), (86, 180, 233)
"""Colors of residuals, as in the report: vermilion without a finding, blue with it."""
FAINT = (*GRAY, 150)
"""Color of the noise floor: visible but unobtrusive."""
BELOW = -1.12
"""Height of the bar of moments, as a share of the largest residual: below all residuals."""
MARK = 0.05
"""Radius of the ball that marks a joint during the moments of its finding, as a share of the arm's reach."""
MAX_PLOTS = 3
"""Maximum number of plots of findings; the list of moments and the diagnosis show all findings."""
COLUMNS = rrb.TextLogColumns(
    timeline_columns=[rrb.encodings.TimelineColumn(TIMELINE, visible=True)], text_log_columns=["body"]
)
"""Columns of the list of moments: time, which can be clicked to go there, and text."""


def diagnosis_view(shown: Shown) -> View:
    """A view of a diagnosis and its samples; without samples it has texts only."""
    model = shown.model
    all_suspects = [] if model is None else suspects(shown)
    sections = [section for section in diagnosis_document(shown).sections if section.blocks]
    texts = {section.anchor: section_markdown(section) for section in sections}

    def log(stream: rr.RecordingStream) -> None:
        for name, words in texts.items():
            log_markdown(stream, f"texts/{name}", words)
        if model is not None:
            for trace in shown.traces:
                _log_run(stream, shown, model, trace, all_suspects)

    texts_view = rrb.Vertical(
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
    layout: rrb.Container = texts_view
    if model is not None and shown.traces:
        runs = [_tab(shown.diagnosis, model, trace, all_suspects) for trace in shown.traces]
        layout = rrb.Horizontal(rrb.Tabs(*runs, active_tab=0), texts_view, column_shares=[3, 1])
    return View("diagnosis", log, screen(layout))


def _tab(diagnosis: Diagnosis, model: Model, trace: Trace, all_suspects: list[Suspect]) -> rrb.Container:
    """Plots on the left, the arm and the list of moments on the right."""
    views: list[rrb.View | rrb.Container] = []
    for suspect in all_suspects[:MAX_PLOTS]:
        unit = TURNING if model.robot.revolute[suspect.joint] else SLIDING
        title = f"{suspect.name}: residual of {diagnosis.joints[suspect.joint]} [{unit}]"
        views.append(_plot(trace, suspect.name, title, legend=not views))
    scale = "over noise floor" if diagnosis.noise_measured_at_rest else "[N m] or [N]"
    residuals = [
        _plot(trace, stage, f"residuals of all joints {words}, {scale}", True)
        for stage, words in (("after", "with findings"), ("before", "without findings"))
    ]
    views += [rrb.Tabs(*residuals, active_tab=0)] if all_suspects else residuals[::-1]
    arm = arm_view(model, arm_name(trace.name))
    beside: rrb.View | rrb.Container = arm
    if all_suspects:
        times = rrb.TextLogView(
            origin=_entity(trace, "moments"), name="moments: click a time to go there", columns=COLUMNS
        )
        beside = rrb.Vertical(arm, times, row_shares=[3, 2])
    role = "held out" if trace.role == HELD_OUT else trace.role
    name = f"{trace.name} ({role})" if role else trace.name
    return rrb.Horizontal(rrb.Vertical(*views), beside, column_shares=[3, 2], name=name)


def _plot(trace: Trace, name: str, title: str, legend: bool) -> rrb.TimeSeriesView:
    return plot(_entity(trace, "residuals", name), title, legend)


def _entity(trace: Trace, *parts: str) -> str:
    """Entity path below a run."""
    return entity("runs", trace.name, *parts)


def _log_run(
    stream: rr.RecordingStream, shown: Shown, model: Model, trace: Trace, all_suspects: list[Suspect]
) -> None:
    """Log residuals, findings and the arm of a run."""
    colors = joint_colors(model.robot.dof)
    scale = shown.diagnosis.noise if shown.diagnosis.noise_measured_at_rest else 1.0
    for stage in ("before", "after"):
        residual = getattr(trace, stage) / scale
        rms = windowed_rms(trace.time, residual, trace.weight)
        path = _entity(trace, "residuals", stage)
        log_lines(stream, path, shown.diagnosis.joints, colors, trace.time, rms, 1.2)
    Arm(stream, model, arm_name(trace.name)).move(trace.time, trace.position)
    for suspect in all_suspects:
        _log_residual(stream, trace, suspect, shown.noise_of(suspect.joint))
        _log_moments(stream, shown.diagnosis, model, trace, suspect)


def _log_residual(stream: rr.RecordingStream, trace: Trace, suspect: Suspect, noise: float | None) -> None:
    """Log a joint's residual without and with a finding, and its noise floor if measured."""
    slides = trace.weight[:, suspect.joint] > 0
    after = trace.after[:, suspect.joint]
    # wider lines are drawn first, in the order of their names, so that no line hides another
    lines = {"1 before": (suspect.before(trace), BEFORE, 2.2), "2 after": (after, AFTER, 1.4)}
    for name, (values, color, width) in lines.items():
        path = _entity(trace, "residuals", suspect.name, name)
        shown = np.where(slides, values, np.nan)
        log_lines(stream, path, [name[2:]], [color], trace.time, shown, width)
    if noise is not None:
        path, levels = _entity(trace, "residuals", suspect.name, "3 noise"), [[noise, -noise]] * 2
        ends = trace.time[[0, -1]]
        log_lines(stream, path, ["noise", "noise"], [FAINT, FAINT], ends, np.array(levels), 1.0)


def _log_moments(
    stream: rr.RecordingStream, diagnosis: Diagnosis, model: Model, trace: Trace, suspect: Suspect
) -> None:
    """Log the moments of a finding: a bar below its residual, rows of text, and a ball on the joint."""
    moments = suspect.moments(trace, diagnosis.noise)
    noise = 0.0 if diagnosis.noise_measured_at_rest else float(diagnosis.noise[suspect.joint])
    ball, radius = _log_ball(stream, model, trace, suspect)
    _resize(stream, ball, float(trace.time[0]), 0.0)
    for moment in moments:
        _resize(stream, ball, moment.begin, radius)
        words = suspect.sentence(moment, trace, model.robot, noise)
        row = rr.TextLog(words, color=suspect.color)
        stream.log(_entity(trace, "moments", suspect.name), row)
        _resize(stream, ball, moment.end, 0.0)
    bar = _entity(trace, "residuals", suspect.name, "4 moments")
    height = BELOW * float(np.max(np.abs(suspect.before(trace) * trace.weight[:, suspect.joint])))
    within = np.zeros(len(trace.time), bool)
    for moment in moments:
        within |= (trace.time >= moment.begin) & (trace.time <= moment.end)
    heights = np.where(within, height, np.nan)
    log_lines(stream, bar, ["moments"], [suspect.color], trace.time, heights, 7.0)


def _resize(stream: rr.RecordingStream, ball: str, time: float, radius: float) -> None:
    """Set the radius of a ball [m] from a time [s] on."""
    stream.set_time(TIMELINE, duration=time)
    stream.log(ball, rr.Points3D.from_fields(radii=[radius]))


def _log_ball(stream: rr.RecordingStream, model: Model, trace: Trace, suspect: Suspect) -> tuple[str, float]:
    """Log a ball in the joint's frame; return its path, and its radius when visible [m]."""
    name = arm_name(trace.name)
    path = entity(name, "marks", suspect.name)
    frame = f"{name}/{link_frames(model.robot.kinematics)[suspect.joint].child}"
    stream.log(path, rr.CoordinateFrame(frame), static=True)
    ball = rr.Points3D.from_fields(positions=[[0.0, 0.0, 0.0]], colors=[suspect.color])
    stream.log(path, ball, static=True)
    return path, MARK * reach(model)
