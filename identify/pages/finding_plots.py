"""Findings, what is left without a name, and every joint, drawn against what they may depend on."""

from collections.abc import Sequence
from dataclasses import replace

from ..diagnosis.candidates import kind_of
from ..diagnosis.findings.diagnosis import Diagnosis
from ..diagnosis.findings.finding import Finding
from ..diagnosis.words.naming import capital, named
from ..diagnosis.words.sentences import dependence
from ..diagnosis.words.size_words import size_words
from ..diagnosis.words.verdict import certainty, headline, left_on, undecided
from ..document.document import Block, Figure, Grid, Heading, Paragraph, Table
from ..text_table import percent
from .diagnosis_plots import orders_plot, profile_plot, size_plot, spectrum_plot, time_plot
from .profiles import AXES, USUAL
from .shown import Shown

WITHOUT = "This diagnosis came without the samples of its runs, so that there is nothing to draw."
FEWEST_POINTS = 3
"""Of a curve that is drawn."""
NOTE = (
    "Residual torque of the joint on which the effect shows best, all else as fitted: before is without "
    "this effect alone, after is with it. Dots are rows and lines means of bins; where the two lines part, "
    "the effect accounts for the difference. Over time and frequency a run is shown that was not fitted, if "
    "there is one."
)


def findings_blocks(shown: Shown, note: str, findings: Sequence[Finding], first: int) -> list[Block]:
    """Plots of findings, the first of which has this index among all; nothing without any."""
    if not findings:
        return []
    blocks: list[Block] = [Paragraph(note if shown.traces else WITHOUT)]
    for place, finding in enumerate(findings, first):
        texts = [words for words in _words(shown, finding) if words]
        blocks += [Heading(shown.finding_names[place]), *(Paragraph(words, "") for words in texts)]
        axes = kind_of(finding.effect).drawn_against or USUAL[:2]
        blocks += _size(shown.diagnosis, finding)
        blocks += _plots(without(shown, place), shown.clearest_joint(finding), axes)
        blocks.append(_alternatives(shown, finding))
    return blocks


def _words(shown: Shown, finding: Finding) -> tuple[str, ...]:
    """What is said of a finding: what is missing and how certain that is, or what it may be."""
    diagnosis, folder = shown.diagnosis, shown.folder
    if finding in diagnosis.undecided:
        return (undecided(diagnosis, finding, folder),)
    return headline(diagnosis, finding), certainty(diagnosis, finding, folder)


def _size(diagnosis: Diagnosis, finding: Finding) -> list[Block]:
    """Its torque over what that depends on, with an interval, and its least and usual and most in words."""
    if (size := finding.size) is None:
        return []
    words = Paragraph(f"{capital(size_words(size, diagnosis))}.", "")
    if len(size.curve) < FEWEST_POINTS:
        return [words]
    remark = "by all its numbers together, with a 95 % band"
    figure = Figure(f"Its torque over {AXES[size.over].words}", remark, size_plot(size, diagnosis))
    return [words, Grid([figure])]


def without(shown: Shown, place: int) -> Shown:
    """The diagnosis with residuals before that lack one finding only, all else as fitted."""
    traces = [replace(trace, before=trace.after + trace.explained[place]) for trace in shown.traces]
    return shown._replace(traces=tuple(traces))


def _plots(shown: Shown, joint: int, axes: Sequence[str]) -> list[Block]:
    """Profiles of all runs, and time and spectrum of one that was held out; nothing without samples."""
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
    for what, motor in (("its own turn", False), ("its motor's turn", True)):
        figures.append(Figure(f"{name} over {what}", "all runs", orders_plot(traces, joint, motor, unit)))
    return [Grid(figures, "three")]


def _alternatives(shown: Shown, finding: Finding) -> Block:
    if not finding.alternatives:
        return Paragraph("Nothing else that exidyn knows explains it as well.")
    rows = [
        [named(other.effect, other.joints, shown.diagnosis.joints), percent(other.probability)]
        for other in finding.alternatives
    ]
    return Table(["not excluded", "probability"], rows)


def unexplained_blocks(shown: Shown) -> list[Block]:
    """What is left and has no name."""
    blocks: list[Block] = []
    for remainder in shown.diagnosis.remainders:
        words = (
            f"{shown.names[remainder.joint]} keeps {left_on(remainder, shown.diagnosis)}, and "
            f"{dependence(remainder.depends_on)} (probability {percent(remainder.probability, 3)})."
        )
        blocks += [Paragraph(words, ""), *_plots(shown, remainder.joint, USUAL)]
    return blocks


def every_joint(shown: Shown) -> list[Block]:
    """Every joint against what it may depend on."""
    if not shown.traces:
        return []
    note = "Residual of every joint, all runs: lines that are flat are a joint that is explained."
    blocks: list[Block] = [Paragraph(note)]
    for joint, name in enumerate(shown.names):
        noise, unit = shown.noise_of(joint), shown.diagnosis.torque_units[joint]
        figures = [
            Figure(f"over {axis}", "", profile_plot(shown.traces, joint, AXES[axis], noise, unit))
            for axis in ("velocity", "position", "load")
        ]
        blocks += [Heading(name), Grid(figures, "three alike")]
    return blocks
