"""The sections of the page, one function each, in the order in which they are read."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from html import escape

import numpy as np

from ...report_html import figure, listing, number, paragraph, section, table, unit
from ...verdict import NORMAL_95
from ..finding import Diagnosis, Finding
from ..forward import Forward
from ..sentences import joint_words
from ..trace import Evidence, Trace
from ..words import headline, named, telling_joint, verdict
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

Section = Callable[[Diagnosis, Forward | None, str], str]
WITHOUT = "This diagnosis came without the samples of its runs, so that there is nothing to draw."


def verdict_section(diagnosis: Diagnosis, forward: Forward | None, folder: str) -> str:
    """What is missing, and how much was gained."""
    content = [_arrows(listing(verdict(diagnosis, folder), "verdict"))]
    if diagnosis.improvement is not None:
        words = ", ".join(diagnosis.improvement.runs)
        remark = f"before: the model at its word, friction and offsets fitted; {words}"
        picture = bars(diagnosis.improvement, _names(diagnosis))
        content.append(_grid(figure("Held-out residual over noise", remark, picture), *_map(diagnosis)))
    if diagnosis.findings:
        content.append(_findings(diagnosis))
    return section("verdict", "Verdict", *content)


def _map(diagnosis: Diagnosis) -> list[str]:
    """Where and when a run held out is not explained, before and after."""
    if diagnosis.evidence is None or diagnosis.improvement is None:
        return []
    trace, noise = _judged(diagnosis)[0], diagnosis.evidence.noise
    maps = [
        f"<h3>{which}</h3>{where_and_when(trace, noise, _names(diagnosis), which)}"
        for which in ("before", "after")
    ]
    return [
        figure("Where and when", f"{trace.name}; white is noise, full colour four times noise", "".join(maps))
    ]


def _findings(diagnosis: Diagnosis) -> str:
    """A row a parameter."""
    rows = []
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
    return table(head, rows, words=(1, 2, 5))


def findings_section(diagnosis: Diagnosis, forward: Forward | None, folder: str) -> str:
    """Pictures of every finding."""
    if not diagnosis.findings:
        return ""
    if diagnosis.evidence is None:
        return section("findings", "Findings", paragraph(WITHOUT))
    note = (
        "Residual torque of the joint on which the effect shows best, all else as fitted: before is without "
        "this effect alone, after is with it. Dots are rows and lines means of bins; where the line of "
        "before leaves the noise and that of after does not, the effect accounts for it. Over time and "
        "frequency a run is shown that was not fitted, if there is one."
    )
    content = [_finding(diagnosis, finding) for finding in diagnosis.findings]
    return section("findings", "Findings", paragraph(note), *content)


def _finding(diagnosis: Diagnosis, finding: Finding) -> str:
    assert diagnosis.evidence is not None
    joint = telling_joint(diagnosis, finding)
    heading = escape(named(finding.effect, finding.joints, diagnosis.joints))
    evidence = without(diagnosis.evidence, diagnosis.findings.index(finding))
    figures = _figures(replace(diagnosis, evidence=evidence), joint, TELLING.get(finding.effect, USUAL[:2]))
    said = _arrows(paragraph(headline(diagnosis, finding), ""))
    return f"<h3>{heading}</h3>{said}{_grid(*figures, kind='three')}{_alternatives(diagnosis, finding)}"


def without(evidence: Evidence, place: int) -> Evidence:
    """Evidence whose residual before lacks one finding only, all else as fitted."""
    traces = [replace(trace, before=trace.after + trace.explained[place]) for trace in evidence.traces]
    return replace(evidence, traces=tuple(traces))


def _figures(diagnosis: Diagnosis, joint: int, axes: Sequence[str]) -> list[str]:
    """Profiles of all runs, and time and spectrum of one that was held out."""
    assert diagnosis.evidence is not None
    evidence, shown = diagnosis.evidence, _judged(diagnosis)
    noise = float(evidence.noise[joint])
    name = joint_words(joint, diagnosis.joints)
    figures = []
    for axis in axes:
        traces = shown[:1] if axis == "time" else evidence.traces
        if picture := profile_plot(traces, joint, AXES[axis], noise):
            figures.append(
                figure(f"{name} over {axis}", "all runs" if len(traces) > 1 else shown[0].name, picture)
            )
    figures.append(figure(f"{name} over time", shown[0].name, time_plot(shown[0], joint, noise)))
    figures.append(figure(f"{name} over frequency", shown[0].name, spectrum_plot(shown[0], joint)))
    for what, motor in (("its own turn", False), ("its motor's turn", True)):
        picture = orders_plot(evidence.traces, joint, motor)
        figures.append(figure(f"{name} over {what}", "all runs", picture))
    return figures


def _alternatives(diagnosis: Diagnosis, finding: Finding) -> str:
    if not finding.alternatives:
        return paragraph("Nothing else that exidyn knows explains it as well.")
    rows = [
        [escape(named(one.effect, one.joints, diagnosis.joints)), f"{number(100 * one.probability, 2)} %"]
        for one in finding.alternatives
    ]
    return table(["not excluded", "probability"], rows)


def unexplained_section(diagnosis: Diagnosis, forward: Forward | None, folder: str) -> str:
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
        if diagnosis.evidence is not None:
            content.append(_grid(*_figures(diagnosis, one.joint, USUAL), kind="three"))
    return section("unexplained", "Unexplained", *content)


def forward_section(diagnosis: Diagnosis, forward: Forward | None, folder: str) -> str:
    """The arm in simulation, before and after."""
    if forward is None:
        return ""
    noise = diagnosis.evidence.noise if diagnosis.evidence else forward.after
    note = (
        f"{forward.run}, simulated in closed loop: an arm with drives of its own follows the recorded "
        "motion, and the torque of its motors is compared with the recorded one. Its motors miss the "
        f"recorded positions by {1e3 * float(np.max(forward.missed)):.2g} mrad at most, root mean square."
    )
    if forward.left_out:
        note += f" Not simulated: {', '.join(one.replace('_', ' ') for one in forward.left_out)}."
    gained = int(np.argmax(forward.before**2 / noise**2 - forward.after**2 / noise**2))
    remark = "simulated less recorded torque, root mean square over noise"
    return section(
        "simulation",
        "Simulation",
        paragraph(note),
        _grid(
            figure("All joints", remark, forward_bars(forward, noise, _names(diagnosis))),
            figure(joint_words(gained, diagnosis.joints), forward.run, forward_plot(forward, gained)),
        ),
    )


def where_section(diagnosis: Diagnosis, forward: Forward | None, folder: str) -> str:
    """Every joint against what it may depend on."""
    if diagnosis.evidence is None:
        return ""
    content = []
    for joint, name in enumerate(_names(diagnosis)):
        noise = float(diagnosis.evidence.noise[joint])
        figures = [
            figure(f"over {axis}", "", profile_plot(diagnosis.evidence.traces, joint, AXES[axis], noise))
            for axis in ("velocity", "position", "load")
        ]
        content.append(f"<h3>{escape(name)}</h3>{_grid(*figures, kind='three')}")
    note = "Residual of every joint, all runs: flat lines within the noise are a joint that is explained."
    return section("joints", "Every joint", paragraph(note), *content)


def data_section(diagnosis: Diagnosis, forward: Forward | None, folder: str) -> str:
    """Runs, and what they do not tell."""
    held_out = ", ".join(diagnosis.improvement.runs) if diagnosis.improvement else "none"
    words = f"Fitted: {', '.join(diagnosis.runs)}; held out: {held_out}."
    doubts = diagnosis.doubts or ("Nothing about the recordings gives rise to doubt.",)
    return section("data", "Runs and doubts", paragraph(words), listing(doubts))


def _judged(diagnosis: Diagnosis) -> list[Trace]:
    """Runs held out, or else all."""
    assert diagnosis.evidence is not None
    traces = list(diagnosis.evidence.traces)
    return [trace for trace in traces if trace.role == "validate"] or traces


def _names(diagnosis: Diagnosis) -> list[str]:
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
