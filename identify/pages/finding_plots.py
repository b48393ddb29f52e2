"""Residual of findings, of unexplained joints and of all joints, over the quantities it may depend on."""

from collections.abc import Sequence
from dataclasses import replace

from ..diagnosis.candidates import kind_of
from ..diagnosis.findings.axes import AXES
from ..diagnosis.findings.diagnosis import Diagnosis
from ..diagnosis.findings.finding import Finding
from ..diagnosis.words.details import details
from ..diagnosis.words.importance import clearest_joint
from ..diagnosis.words.measures import size_words
from ..diagnosis.words.naming import capital
from ..diagnosis.words.sentences import dependence
from ..diagnosis.words.verdict import verdict
from ..document.document import Block, Figure, Folded, Grid, Heading, Paragraph
from .diagnosis_plots import profile_plot, size_plot, spectrum_plot, time_plot
from .shown import Shown

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
        left = [r.depends_on for r in shown.diagnosis.remainders if r.joint == joint]
        figures = _plots(shown, joint, USUAL) if left else _plots(shown, joint, USUAL[:3])[:3]
        blocks += [Heading(": ".join([name, *map(dependence, left)])), Grid(figures, "three")]
    return blocks
