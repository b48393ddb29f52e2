"""Findings, what is left without a name, and every joint, drawn against what they may depend on."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..diagnosis.candidates import kind_of
from ..diagnosis.words.diagnosis_schema import FindingRow
from ..diagnosis.words.naming import capital, named
from ..diagnosis.words.sentences import dependence
from ..document.document import Block, Figure, Grid, Heading, Paragraph, Table
from ..text_table import digits, percent
from .diagnosed import Diagnosed, moments, name_of_finding
from .diagnosis_plots import orders_plot, profile_plot, size_plot, spectrum_plot, time_plot
from .profiles import AXES, USUAL

WITHOUT = "This diagnosis came without the samples of its runs, so that there is nothing to draw."
FEWEST_POINTS = 3
"""Of a curve that is drawn."""
NOTE = (
    "Residual torque of the joint on which the effect shows best, all else as fitted: before is without "
    "this effect alone, after is with it. Dots are rows and lines means of bins; where the two lines part, "
    "the effect accounts for the difference. Over time and frequency a run is shown that was not fitted, if "
    "there is one."
)


def findings_blocks(
    diagnosis: Diagnosed, note: str, findings: Sequence[FindingRow], first: int
) -> list[Block]:
    """Plots of findings, the first of which has this place among all; nothing without any."""
    if not findings:
        return []
    blocks: list[Block] = [Paragraph(note if diagnosis.traces else WITHOUT)]
    for place, one in enumerate(findings, first):
        texts = [words for words in (one.headline or f"{one.sentence}.", one.certainty) if words]
        blocks += [Heading(name_of_finding(diagnosis, one)), *(Paragraph(words, "") for words in texts)]
        axes = kind_of(one.effect).drawn_against or USUAL[:2]
        blocks += _size(one)
        blocks += _plots(without(diagnosis, place), diagnosis.clearest_joint(one), axes)
        blocks.append(_alternatives(diagnosis, one))
    return blocks


def _size(finding: FindingRow) -> list[Block]:
    """Its torque over what that depends on, with an interval, and its least and usual and most in words."""
    if (size := finding.size) is None:
        return []
    words = Paragraph(f"{capital(size.sentence)}.", "")
    if len(size.curve) < FEWEST_POINTS:
        return [words]
    remark = "by all its numbers together, with a 95 % band"
    return [words, Grid([Figure(f"Its torque over {size.over}", remark, size_plot(size))])]


def without(diagnosis: Diagnosed, place: int) -> Diagnosed:
    """The diagnosis with residuals before that lack one finding only, all else as fitted."""
    traces = [replace(trace, before=trace.after + trace.explained[place]) for trace in diagnosis.traces]
    return diagnosis._replace(traces=tuple(traces))


def _plots(diagnosis: Diagnosed, joint: int, axes: Sequence[str]) -> list[Block]:
    """Profiles of all runs, and time and spectrum of one that was held out; nothing without samples."""
    if not diagnosis.traces:
        return []
    traces, shown = diagnosis.traces, diagnosis.judged[0]
    noise, name, unit = diagnosis.noise_of(joint), diagnosis.names[joint], diagnosis.file.units[joint]
    figures = []
    for axis in axes:
        drawn = (shown,) if axis == "time" else traces
        if picture := profile_plot(drawn, joint, AXES[axis], noise, unit):
            remark = "all runs" if len(drawn) > 1 else drawn[0].name
            figures.append(Figure(f"{name} over {axis}", remark, picture))
    over_time = time_plot(shown, joint, noise, unit, moments(diagnosis.file))
    figures.append(Figure(f"{name} over time", shown.name, over_time))
    figures.append(Figure(f"{name} over frequency", shown.name, spectrum_plot(shown, joint, unit)))
    for what, motor in (("its own turn", False), ("its motor's turn", True)):
        figures.append(Figure(f"{name} over {what}", "all runs", orders_plot(traces, joint, motor, unit)))
    return [Grid(figures, "three")]


def _alternatives(diagnosis: Diagnosed, finding: FindingRow) -> Block:
    if not finding.alternatives:
        return Paragraph("Nothing else that exidyn knows explains it as well.")
    rows = [
        [
            named(one.effect, [j - 1 for j in one.joints], diagnosis.file.joints),
            percent(one.probability or 0.0),
        ]
        for one in finding.alternatives
    ]
    return Table(["not excluded", "probability"], rows)


def unexplained_blocks(diagnosis: Diagnosed) -> list[Block]:
    """What is left and has no name."""
    blocks: list[Block] = []
    for one in diagnosis.file.remainders:
        # Older files give it over noise only.
        left = one.left or f"{digits(one.over_noise or np.nan, 3)} x noise"
        said = (
            f"{diagnosis.names[one.joint - 1]} keeps {left}, and {dependence(one.depends_on)} "
            f"(probability {percent(one.probability, 3)})."
        )
        blocks += [Paragraph(said, ""), *_plots(diagnosis, one.joint - 1, USUAL)]
    return blocks


def every_joint(diagnosis: Diagnosed) -> list[Block]:
    """Every joint against what it may depend on."""
    if not diagnosis.traces:
        return []
    note = "Residual of every joint, all runs: lines that are flat are a joint that is explained."
    blocks: list[Block] = [Paragraph(note)]
    for joint, name in enumerate(diagnosis.names):
        noise, unit = diagnosis.noise_of(joint), diagnosis.file.units[joint]
        figures = [
            Figure(f"over {axis}", "", profile_plot(diagnosis.traces, joint, AXES[axis], noise, unit))
            for axis in ("velocity", "position", "load")
        ]
        blocks += [Heading(name), Grid(figures, "three alike")]
    return blocks
