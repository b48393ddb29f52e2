"""Plots of a diagnosis, over recorded quantities, time and frequency, beside the words of its findings."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..diagnosis.candidates import kind_of
from ..diagnosis.findings.axes import AXES, Axis
from ..diagnosis.findings.diagnosis import Diagnosis, Moment
from ..diagnosis.findings.evidence import Trace
from ..diagnosis.findings.finding import Finding
from ..diagnosis.findings.quantities import TURNING
from ..diagnosis.findings.size import Size
from ..diagnosis.words.importance import clearest_joint
from ..diagnosis.words.measures import size_words
from ..diagnosis.words.naming import capital
from ..diagnosis.words.sentences import dependence
from ..diagnosis.words.verdict import details, verdict
from ..document.document import Block, Figure, Folded, Grid, Heading, Paragraph
from ..text_table import NORMAL_95
from .shown import Shown
from .svg import Panel, Span, stretch

DOTS = 500
"""Number of dots in a profile; more would hide one another."""
STRETCH = 20.0
"""Longest part of a run that is drawn [s]."""
KEYS = [("before", "before"), ("after", "after")]
BINS = 28
"""Number of bins in a profile; in a run of half a minute, each has some hundred rows."""
FEWEST = 8
"""Smallest number of rows for which the mean of a bin is drawn."""


class Profile(NamedTuple):
    """Means of a residual in bins."""

    x: np.ndarray  # middle of each bin, shape (b,)
    mean: np.ndarray  # mean residual in each bin, shape (b,) [N m]
    dots: np.ndarray  # value on the axis and residual of every row, shape (r, 2)


def profile(traces: Sequence[Trace], joint: int, axis: Axis, residuals: str) -> Profile:
    """A joint's residual against an axis.

    `residuals` is "before" or "after".
    """
    x, y = [], []
    for trace in traces:
        sliding = trace.weight[:, joint] > 0
        sign = np.sign(trace.velocity[:, joint]) if axis.braking else 1.0
        x.append(axis.values(trace, joint)[sliding])
        y.append((getattr(trace, residuals)[:, joint] * sign)[sliding])
    dots = np.column_stack([np.concatenate(x), np.concatenate(y)])
    dots = dots[np.all(np.isfinite(dots), axis=1)]
    return Profile(*_means(dots), dots)


def _means(dots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middles and means of bins of equal width that have enough rows."""
    if len(dots) < FEWEST or np.ptp(dots[:, 0]) == 0.0:
        return np.zeros(0), np.zeros(0)
    edges = np.linspace(dots[:, 0].min(), dots[:, 0].max(), BINS + 1)
    places = np.clip(np.digitize(dots[:, 0], edges) - 1, 0, BINS - 1)
    counts = np.bincount(places, minlength=BINS)
    sums = [np.bincount(places, dots[:, column], minlength=BINS) for column in (0, 1)]
    enough = counts >= FEWEST
    return sums[0][enough] / counts[enough], sums[1][enough] / counts[enough]


def spectrum(trace: Trace, joint: int, residuals: str) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and amplitudes [N m] of a joint's residual, averaged to a smooth line."""
    values = getattr(trace, residuals)[:, joint] * trace.weight[:, joint]
    rate = 1.0 / float(np.median(np.diff(trace.time)))
    length = min(256, len(values))
    window = np.hanning(length)
    starts = range(0, len(values) - length + 1, length // 2)
    pieces = np.array([values[start : start + length] for start in starts]) * window
    power = np.mean(np.abs(np.fft.rfft(pieces, axis=1)) ** 2, axis=0)
    return np.fft.rfftfreq(length, 1.0 / rate), 2.0 * np.sqrt(power) / window.sum()


def profile_plot(
    traces: Sequence[Trace], joint: int, axis: Axis, noise: float | None, unit: str = TURNING
) -> str:
    """Residual of a joint over a recorded quantity, before and after: dots, and means of bins."""
    before, after = (profile(traces, joint, axis, stage) for stage in ("before", "after"))
    if not len(before.dots):
        return ""
    across, label = Span.around(before.dots[:, 0], margin=0.02), axis.title(unit == TURNING)
    heights = [np.percentile(points.dots[:, 1], [1, 99]) for points in (before, after)]
    height = Span.around(*heights, before.mean, np.array([noise or 0.0]), zero=True)
    panel = Panel.single(across, height)
    y_label = f"residual against the motion [{unit}]" if axis.braking else f"residual [{unit}]"
    return panel.plot(
        f"residual over {label}",
        (label, y_label),
        _keys(noise),
        _band(panel, noise),
        _dots(panel, before, "cloud"),
        _dots(panel, after, "cloudafter"),
        panel.line(before.x, before.mean, "before"),
        panel.line(after.x, after.mean, "after"),
    )


def size_plot(size: Size, diagnosis: Diagnosis) -> str:
    """Torque of a finding over the quantity it depends on, with a 95 % band."""
    x, torque, std = np.array([(point.at, point.torque, point.std) for point in size.curve]).T
    low, high = torque - NORMAL_95 * std, torque + NORMAL_95 * std
    panel = Panel.single(Span.around(x, margin=0.02), Span.around(low, high, np.zeros(1)))
    axis, unit = AXES[size.over], diagnosis.torque_units[size.joint]
    label = axis.title(unit == TURNING)
    quantity = "torque against the motion" if axis.braking else "torque"
    reference = " relative to the first" if size.change else ""
    marks = panel.band(x, low, high, "sure"), panel.line(x, torque, "after")
    return panel.plot(f"torque over {label}", (label, f"{quantity}{reference} [{unit}]"), (), *marks)


def _keys(noise: float | None) -> list[tuple[str, str]]:
    return KEYS if noise is None else [*KEYS, ("bandkey", "noise")]


def _band(panel: Panel, noise: float | None) -> str:
    return "" if noise is None else panel.level(-noise, noise, "band")


def _dots(panel: Panel, points: Profile, style: str) -> str:
    chosen = np.unique(np.linspace(0, len(points.dots) - 1, min(DOTS, len(points.dots))).astype(int))
    return panel.dots(points.dots[chosen, 0], points.dots[chosen, 1], style)


def time_plot(
    trace: Trace, joint: int, noise: float | None, unit: str = TURNING, moments: Sequence[Moment] = ()
) -> str:
    """Residual of a run over time, before and after, in its worst stretch, with moments marked."""
    shown = stretch(trace.time, trace.before[:, joint] ** 2 * trace.weight[:, joint], STRETCH)
    time, slides = trace.time[shown], trace.weight[shown, joint] > 0
    before, after = (np.where(slides, rows[shown, joint], np.nan) for rows in (trace.before, trace.after))
    panel = Panel.single(Span.around(time, margin=0.0), Span.around(before, after, zero=True))
    marks = [
        _mark(panel, moment) for moment in moments if moment.run == trace.name and joint in moment.joints
    ]
    return panel.plot(
        f"{trace.name}: residual over time",
        ("time [s]", f"residual [{unit}]"),
        _keys(noise) + ([("momentkey", "moment")] if any(marks) else []),
        *marks,
        _band(panel, noise),
        panel.line(time, before, "before thin"),
        panel.line(time, after, "after thin"),
    )


def _mark(panel: Panel, moment: Moment) -> str:
    """A moment as a stripe; empty if it lies outside the panel."""
    start, end = max(moment.start, panel.x.low), min(moment.end, panel.x.high)
    return panel.stripe(start, end, "moment") if end > start else ""


def spectrum_plot(trace: Trace, joint: int, unit: str = TURNING) -> str:
    """Amplitude of a residual over frequency, before and after."""
    lines = [spectrum(trace, joint, stage) for stage, _ in KEYS]
    top = max(float(np.max(amplitude)) for _, amplitude in lines)
    panel = Panel.single(Span.around(lines[0][0], margin=0.0), Span(0.0, 1.06 * top or 1.0))
    drawn = [panel.line(*line, style) for line, (style, _) in zip(lines, KEYS, strict=True)]
    labels = "frequency [Hz]", f"residual, amplitude [{unit}]"
    return panel.plot("residual over frequency [Hz]", labels, KEYS, *drawn)


WITHOUT = "There are no plots because this diagnosis was loaded without the samples of its runs."
USUAL = ("velocity", "position", "load", "acceleration", "time", "motor angle")
"""Axes on which a residual is drawn: on the first three that of any joint, on all an unexplained one."""
FEWEST_POINTS = 3
"""Smallest number of points for which a curve is drawn."""
NOTE = (
    "Residual torque of the joint that shows the effect best. Before: all findings except this one. After: "
    "all findings. Dots are samples, and lines are means of bins; the effect explains the difference "
    "between the two lines. Plots over time and frequency show a held-out run if there is one."
)


def findings_blocks(shown: Shown, note: str, findings: Sequence[Finding], first: int) -> list[Block]:
    """Words and plots of findings; `first` is the index of the first one among all findings."""
    if not findings:
        return []
    blocks: list[Block] = [Paragraph(note if shown.traces else WITHOUT, "plot")]
    said = verdict(shown.diagnosis, shown.folder)[0]
    for place, finding in enumerate(findings, first):
        words = " ".join(line for line in details(shown.diagnosis, finding, shown.folder) if line != said)
        blocks += [Heading(shown.finding_names[place]), Paragraph(words, "")]
        axes = kind_of(finding.effect).drawn_against or USUAL[:2]
        size_sentence, size_figure = _size(shown.diagnosis, finding)
        plots = _plots(without(shown, place), clearest_joint(shown.diagnosis, finding), axes)
        figures = [figure for figure in (*plots[:1], size_figure) if figure is not None]
        blocks += [*size_sentence, Grid(figures)]
        if plots[1:]:
            blocks.append(Folded("More plots of this joint", [Grid(plots[1:], "three")]))
    return blocks


def _size(diagnosis: Diagnosis, finding: Finding) -> tuple[list[Paragraph], Figure | None]:
    """Torque of a finding over the quantity it depends on, in words and as a curve."""
    if (size := finding.size) is None:
        return [], None
    words = Paragraph(f"{capital(size_words(size, diagnosis))}.", "")
    if len(size.curve) < FEWEST_POINTS:
        return [words], None
    remark = "all parameters together, with a 95 % band"
    plot = size_plot(size, diagnosis)
    return [words], Figure(f"Torque of the effect over {AXES[size.over].words}", remark, plot)


def without(shown: Shown, place: int) -> Shown:
    """The diagnosis with "before" residuals that lack only the finding at this index."""
    traces = [replace(trace, before=trace.after + trace.explained[place]) for trace in shown.traces]
    return shown._replace(traces=tuple(traces))


def _plots(shown: Shown, joint: int, axes: Sequence[str]) -> list[Figure]:
    """Profiles of all runs, then time and spectra of a held-out run; empty without samples."""
    if not shown.traces:
        return []
    traces, judged = shown.traces, shown.judged[0]
    noise, name, unit = shown.noise_of(joint), shown.names[joint], shown.diagnosis.torque_units[joint]
    figures = []
    for axis in axes:
        drawn = (judged,) if axis == "time" else traces
        if picture := profile_plot(drawn, joint, AXES[axis], noise, unit):
            remark = "all runs" if len(drawn) > 1 else drawn[0].name
            figures.append(Figure(f"{name} over {axis}", remark, picture))
    over_time = time_plot(judged, joint, noise, unit, shown.diagnosis.moments)
    figures.append(Figure(f"{name} over time", judged.name, over_time))
    figures.append(Figure(f"{name} over frequency", judged.name, spectrum_plot(judged, joint, unit)))
    return figures


def every_joint(shown: Shown) -> list[Block]:
    """Residual of every joint; of an unexplained one, over all quantities, time and frequency."""
    if not shown.traces:
        return []
    note = "Residual of every joint in all runs. Flat lines mean that the model explains the joint."
    blocks: list[Block] = [Paragraph(note)]
    for joint, name in enumerate(shown.names):
        unexplained = [r.depends_on for r in shown.diagnosis.remainders if r.joint == joint]
        figures = _plots(shown, joint, USUAL) if unexplained else _plots(shown, joint, USUAL[:3])[:3]
        blocks += [Heading(": ".join([name, *map(dependence, unexplained)])), Grid(figures, "three")]
    return blocks
