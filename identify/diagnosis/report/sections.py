"""The sections of the page, one function each, in the order in which they are read."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from html import escape

import numpy as np

from ...report_html import figure, listing, number, paragraph, section, table, unit
from ...verdict import NORMAL_95
from ..sentences import joint_words
from ..words import named
from .plots import (
    bars,
    forward_bars,
    forward_plot,
    orders_plot,
    profile_plot,
    spectrum_plot,
    time_plot,
    where_and_when,
)
from .profiles import AXES, TELLING, USUAL
from .told import Named, Told

Section = Callable[[Told], str]
WITHOUT = "This diagnosis came without the samples of its runs, so that there is nothing to draw."


def verdict_section(diagnosis: Told) -> str:
    """What is missing, and how much was gained."""
    content = [said(diagnosis), improvement(diagnosis), findings_table(diagnosis)]
    return section("verdict", "Verdict", *content)


def said(diagnosis: Told) -> str:
    """The verdict in sentences."""
    return _arrows(listing(diagnosis.verdict, "verdict"))


def improvement(diagnosis: Told) -> str:
    """Residual held out before and after, by joint, and where and when it is; nothing without such runs."""
    if diagnosis.improvement is None:
        return ""
    words = ", ".join(diagnosis.improvement.runs)
    remark = f"before: the model at its word, friction and offsets fitted; {words}"
    picture = bars(diagnosis.improvement, _names(diagnosis))
    return _grid(figure("Held-out residual over noise", remark, picture), *_map(diagnosis))


def _map(diagnosis: Told) -> list[str]:
    """Where and when a run held out is not explained, before and after."""
    if not diagnosis.traces:
        return []
    trace, noise = diagnosis.judged[0], diagnosis.noise
    maps = [
        f"<h3>{which}</h3>{where_and_when(trace, noise, _names(diagnosis), which)}"
        for which in ("before", "after")
    ]
    return [
        figure("Where and when", f"{trace.name}; white is noise, full colour four times noise", "".join(maps))
    ]


def findings_table(diagnosis: Told) -> str:
    """A row a parameter; nothing without findings."""
    rows: list[list[str]] = []
    for finding in diagnosis.findings:
        where = ", ".join(diagnosis.joints[joint] for joint in finding.joints) or "arm"
        first = [escape(finding.effect.replace("_", " ")), escape(where)]
        last = [f"{number(100 * finding.probability)} %", number(finding.held_out, 3)]
        for name, (value, std, measure) in finding.parameters.items():
            half = number(NORMAL_95 * std, 2)
            shown = "" if measure == "1" else unit(measure)
            rows.append([*first, escape(name), number(value), half, shown, *last])
            first, last = ["", ""], ["", ""]
    head = ["effect", "where", "parameter", "value", "± 95 %", "unit", "probability", "gain held out"]
    return table(head, rows, words=(1, 2, 5)) if rows else ""


def findings_section(diagnosis: Told) -> str:
    """Pictures of every finding."""
    if not diagnosis.findings:
        return ""
    note = (
        "Residual torque of the joint on which the effect shows best, all else as fitted: before is without "
        "this effect alone, after is with it. Dots are rows and lines means of bins; where the line of "
        "before leaves the noise and that of after does not, the effect accounts for it. Over time and "
        "frequency a run is shown that was not fitted, if there is one."
    )
    content = [_finding(diagnosis, place) for place in range(len(diagnosis.findings))]
    return section("findings", "Findings", paragraph(note if diagnosis.traces else WITHOUT), *content)


def _finding(diagnosis: Told, place: int) -> str:
    finding = diagnosis.findings[place]
    words = _arrows(paragraph(finding.headline, "") + paragraph(finding.certainty, ""))
    axes = TELLING.get(finding.effect, USUAL[:2])
    figures = _figures(without(diagnosis, place), diagnosis.telling_joint(finding), axes)
    return f"<h3>{escape(finding.name)}</h3>{words}{figures}{_alternatives(diagnosis, finding)}"


def without(diagnosis: Told, place: int) -> Told:
    """The diagnosis with residuals before that lack one finding only, all else as fitted."""
    traces = [replace(trace, before=trace.after + trace.explained[place]) for trace in diagnosis.traces]
    return replace(diagnosis, traces=tuple(traces))


def _figures(diagnosis: Told, joint: int, axes: Sequence[str]) -> str:
    """Profiles of all runs, and time and spectrum of one that was held out; nothing without samples."""
    if not diagnosis.traces:
        return ""
    traces, shown = diagnosis.traces, diagnosis.judged[0]
    noise, name = float(diagnosis.noise[joint]), joint_words(joint, diagnosis.joints)
    figures = []
    for axis in axes:
        drawn = (shown,) if axis == "time" else traces
        if picture := profile_plot(drawn, joint, AXES[axis], noise):
            remark = "all runs" if len(drawn) > 1 else drawn[0].name
            figures.append(figure(f"{name} over {axis}", remark, picture))
    figures.append(figure(f"{name} over time", shown.name, time_plot(shown, joint, noise)))
    figures.append(figure(f"{name} over frequency", shown.name, spectrum_plot(shown, joint)))
    for what, motor in (("its own turn", False), ("its motor's turn", True)):
        figures.append(figure(f"{name} over {what}", "all runs", orders_plot(traces, joint, motor)))
    return _grid(*figures, kind="three")


def _alternatives(diagnosis: Told, finding: Named) -> str:
    if not finding.alternatives:
        return paragraph("Nothing else that exidyn knows explains it as well.")
    rows = [
        [escape(named(one.effect, one.joints, diagnosis.joints)), f"{number(100 * one.probability, 2)} %"]
        for one in finding.alternatives
    ]
    return table(["not excluded", "probability"], rows)


def unexplained_section(diagnosis: Told) -> str:
    """What is left and has no name."""
    if not diagnosis.remainders:
        return ""
    content = []
    for one in diagnosis.remainders:
        said = (
            f"{joint_words(one.joint, diagnosis.joints)} keeps {one.over_noise:.2f} x noise, and what is "
            f"left goes with {one.depends_on} (probability {100 * one.probability:.4g} %)."
        )
        content.append(paragraph(said, ""))
        content.append(_figures(diagnosis, one.joint, USUAL))
    return section("unexplained", "Unexplained", *content)


def forward_section(diagnosis: Told) -> str:
    """The arm in simulation, before and after."""
    if (found := diagnosis.simulated) is None:
        return ""
    noise = diagnosis.noise if len(diagnosis.noise) else found.after
    note = (
        f"{found.run}, simulated in closed loop: an arm with drives of its own follows the recorded "
        "motion, and the torque of its motors is compared with the recorded one."
    )
    remark = "simulated less recorded torque, root mean square over noise"
    figures = [figure("All joints", remark, forward_bars(found, noise, _names(diagnosis)))]
    if (samples := found.samples) is not None:
        missed = 1e3 * float(np.max(samples.missed))
        note += f" Its motors miss the recorded positions by {missed:.2g} mrad at most, root mean square."
        gained = int(np.argmax((found.before**2 - found.after**2) / noise**2))
        figures.append(
            figure(joint_words(gained, diagnosis.joints), found.run, forward_plot(samples, gained))
        )
    if found.left_out:
        note += f" Not simulated: {', '.join(one.replace('_', ' ') for one in found.left_out)}."
    return section("simulation", "Simulation", paragraph(note), _grid(*figures))


def where_section(diagnosis: Told) -> str:
    """Every joint against what it may depend on."""
    if not diagnosis.traces:
        return ""
    content = []
    for joint, name in enumerate(_names(diagnosis)):
        noise = float(diagnosis.noise[joint])
        figures = [
            figure(f"over {axis}", "", profile_plot(diagnosis.traces, joint, AXES[axis], noise))
            for axis in ("velocity", "position", "load")
        ]
        content.append(f"<h3>{escape(name)}</h3>{_grid(*figures, kind='three')}")
    note = "Residual of every joint, all runs: flat lines within the noise are a joint that is explained."
    return section("joints", "Every joint", paragraph(note), *content)


def data_section(diagnosis: Told) -> str:
    """Runs, and what they do not tell."""
    held_out = ", ".join(diagnosis.improvement.runs) if diagnosis.improvement else "none"
    words = f"Fitted: {', '.join(diagnosis.runs)}; held out: {held_out}."
    doubts = diagnosis.doubts or ("Nothing about the recordings gives rise to doubt.",)
    return section("data", "Runs and doubts", paragraph(words), listing(doubts))


def _names(diagnosis: Told) -> list[str]:
    return [joint_words(joint, diagnosis.joints) for joint in range(len(diagnosis.joints))]


def _arrows(html: str) -> str:
    return html.replace("-&gt;", "\N{RIGHTWARDS ARROW}")


def _grid(*figures: str, kind: str = "two") -> str:
    return f'<div class="grid {kind}">{"".join(figures)}</div>'


SECTIONS: tuple[Section, ...] = (
    verdict_section,
    findings_section,
    unexplained_section,
    forward_section,
    where_section,
    data_section,
)
"""Of a page of its own."""

DETAILS = (findings_section, unexplained_section, where_section, data_section)
"""Of a page on which others say the verdict, and what was gained."""
