"""The sections of the page, one function each, in the order in which they are read."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...diagnosis.candidates import kind_of
from ...diagnosis.findings.finding import Improvement
from ...diagnosis.findings.quantities import SLIDING, TURNING
from ...diagnosis.words.naming import effect_words, joint_words, named
from ...fit.verdict import NORMAL_95
from ..report_html import figure, grid, heading, listing, number, paragraph, section, table, unit
from .budget_section import budget_section
from .candidates_section import changes_section, moments_section
from .page_data import Named, PageData, Simulated
from .plots import (
    bars,
    forward_plot,
    orders_plot,
    profile_plot,
    spectrum_plot,
    time_plot,
    where_and_when,
)
from .profiles import AXES, USUAL

Section = Callable[[PageData], str]
WITHOUT = "This diagnosis came without the samples of its runs, so that there is nothing to draw."


def verdict_section(diagnosis: PageData) -> str:
    """What is missing, and how much was gained."""
    content = [verdict_list(diagnosis), improvement(diagnosis), findings_table(diagnosis)]
    return section("verdict", "Verdict", *content)


def verdict_list(diagnosis: PageData) -> str:
    """The verdict in sentences."""
    return listing(map(_arrows, diagnosis.verdict), "verdict")


def improvement(diagnosis: PageData) -> str:
    """Residual held out before and after, by joint, and where and when it is; nothing without such runs."""
    if (found := diagnosis.improvement) is None:
        return ""
    remark = f"before: nominal values, friction and offsets fitted; {', '.join(found.runs)}"
    over = " over noise" if diagnosis.over_noise else ""
    picture = _bars(diagnosis, found, found.noise, "residual", _units(diagnosis))
    return grid(figure(f"Held-out residual{over}", remark, picture), *_map(diagnosis))


def _bars(
    diagnosis: PageData, found: Improvement | Simulated, noise: np.ndarray, label: str, units: Sequence[str]
) -> str:
    """Bars in units, or over noise (n,) where there are none."""
    if units:
        return bars(found.before, found.after, _names(diagnosis), label, units)
    over = label + (", over noise" if isinstance(found, Simulated) else " over noise")
    return bars(found.before / noise, found.after / noise, _names(diagnosis), over)


def _units(diagnosis: PageData) -> tuple[str, ...]:
    """Units of bars; none where they are over noise."""
    return () if diagnosis.over_noise else diagnosis.units


def _noise(diagnosis: PageData, joint: int) -> float | None:
    """Noise floor of a joint; None where it was not measured."""
    return float(diagnosis.noise[joint]) if diagnosis.over_noise and len(diagnosis.noise) else None


def _map(diagnosis: PageData) -> list[str]:
    """Where and when a run held out is not explained, before and after."""
    if not diagnosis.traces:
        return []
    trace = diagnosis.judged[0]
    level, what = diagnosis.noise, "noise"
    if not diagnosis.over_noise:
        squares = np.sum(trace.after**2 * trace.weight, axis=0) / np.maximum(trace.weight.sum(axis=0), 1.0)
        level, what = np.maximum(np.sqrt(squares), 1e-300), "the joint's root mean square after"
    maps = [
        heading(which) + where_and_when(trace, level, _names(diagnosis), which)
        for which in ("before", "after")
    ]
    remark = f"{trace.name}; white is {what}, full colour four times that"
    return [figure("Where and when", remark, "".join(maps))]


def findings_table(diagnosis: PageData) -> str:
    """A row a parameter, undecided findings last; nothing without findings."""
    rows: list[list[str]] = []
    for finding in (*diagnosis.findings, *diagnosis.undecided):
        where = ", ".join(diagnosis.joints[joint] for joint in finding.joints) or "arm"
        first = [effect_words(finding.effect), where]
        last: list[str] = [number(100 * finding.probability) + " %", number(finding.held_out, 3)]
        for name, (value, std, measure) in finding.parameters.items():
            half = number(NORMAL_95 * std, 2)
            shown = "" if measure == "1" else unit(measure)
            rows.append([*first, name, number(value), half, shown, *last])
            first = last = ["", ""]
    head = ["effect", "where", "parameter", "value", "± 95 %", "unit", "probability", "gain held out"]
    return table(head, rows, words=(1, 2, 5)) if rows else ""


NOTE = (
    "Residual torque of the joint on which the effect shows best, all else as fitted: before is without "
    "this effect alone, after is with it. Dots are rows and lines means of bins; where the two lines part, "
    "the effect accounts for the difference. Over time and frequency a run is shown that was not fitted, if "
    "there is one."
)


def findings_section(diagnosis: PageData) -> str:
    """Pictures of every finding."""
    return _pictures(diagnosis, "findings", NOTE, diagnosis.findings, 0)


def undecided_section(diagnosis: PageData) -> str:
    """Pictures of what is there and has no certain name, as the one that was fitted has it."""
    note = "Each is there; these runs do not decide which. Pictures are of the one that was fitted."
    return _pictures(diagnosis, "undecided", note, diagnosis.undecided, len(diagnosis.findings))


def _pictures(diagnosis: PageData, anchor: str, note: str, findings: Sequence[Named], first: int) -> str:
    """A section of findings, the first of which has this place among all; nothing without any."""
    if not findings:
        return ""
    content = [_finding(diagnosis, one, place) for place, one in enumerate(findings, first)]
    shown = paragraph(note if diagnosis.traces else WITHOUT)
    return section(anchor, anchor.capitalize(), shown, *content)


def _finding(diagnosis: PageData, finding: Named, place: int) -> str:
    text = [paragraph(_arrows(one), "") for one in (finding.headline, finding.certainty) if one]
    axes = kind_of(finding.effect).drawn_against or USUAL[:2]
    figures = _figures(without(diagnosis, place), diagnosis.clearest_joint(finding), axes)
    return "".join([heading(finding.name), *text, figures, _alternatives(diagnosis, finding)])


def without(diagnosis: PageData, place: int) -> PageData:
    """The diagnosis with residuals before that lack one finding only, all else as fitted."""
    traces = [replace(trace, before=trace.after + trace.explained[place]) for trace in diagnosis.traces]
    return replace(diagnosis, traces=tuple(traces))


def _figures(diagnosis: PageData, joint: int, axes: Sequence[str]) -> str:
    """Profiles of all runs, and time and spectrum of one that was held out; nothing without samples."""
    if not diagnosis.traces:
        return ""
    traces, shown = diagnosis.traces, diagnosis.judged[0]
    noise, name = _noise(diagnosis, joint), joint_words(joint, diagnosis.joints)
    unit = diagnosis.units[joint]
    figures = []
    for axis in axes:
        drawn = (shown,) if axis == "time" else traces
        if picture := profile_plot(drawn, joint, AXES[axis], noise, unit):
            remark = "all runs" if len(drawn) > 1 else drawn[0].name
            figures.append(figure(f"{name} over {axis}", remark, picture))
    over_time = time_plot(shown, joint, noise, unit, diagnosis.moments)
    figures.append(figure(f"{name} over time", shown.name, over_time))
    figures.append(figure(f"{name} over frequency", shown.name, spectrum_plot(shown, joint, unit)))
    for what, motor in (("its own turn", False), ("its motor's turn", True)):
        figures.append(figure(f"{name} over {what}", "all runs", orders_plot(traces, joint, motor, unit)))
    return grid(*figures, kind="three")


def _alternatives(diagnosis: PageData, finding: Named) -> str:
    if not finding.alternatives:
        return paragraph("Nothing else that exidyn knows explains it as well.")
    rows = [
        [named(one.effect, one.joints, diagnosis.joints), number(100 * one.probability, 2) + " %"]
        for one in finding.alternatives
    ]
    return table(["not excluded", "probability"], rows)


def unexplained_section(diagnosis: PageData) -> str:
    """What is left and has no name."""
    if not diagnosis.remainders:
        return ""
    content = []
    for one in diagnosis.remainders:
        text = (
            f"{joint_words(one.joint, diagnosis.joints)} keeps {one.size}, and what is left depends on "
            f"{one.depends_on} (probability {100 * one.probability:.4g} %)."
        )
        content += [paragraph(text, ""), _figures(diagnosis, one.joint, USUAL)]
    return section("unexplained", "Unexplained", *content)


def forward_section(diagnosis: PageData) -> str:
    """The arm in simulation, before and after."""
    if (found := diagnosis.simulated) is None:
        return ""
    note = (
        f"{found.run}, simulated in closed loop: an arm with drives of its own follows the recorded "
        "motion, and the torque of its motors is compared with the recorded one."
    )
    noise = diagnosis.noise if len(diagnosis.noise) else np.ones(len(diagnosis.joints))
    units = _units(diagnosis) if len(diagnosis.noise) else diagnosis.units
    remark = f"simulated less recorded torque, root mean square{'' if units else ' over noise'}"
    figures = [figure("All joints", remark, _bars(diagnosis, found, noise, "simulated less recorded", units))]
    if not np.all(np.isfinite([found.before, found.after])):
        note += " It diverged: where it did, there is no number."
    if (samples := found.samples) is not None:
        missed = 1e3 * float(np.max(samples.missed))
        if np.isfinite(missed):
            note += f" Its motors miss the recorded positions by {missed:.2g} {_small(diagnosis)} at most, "
            note += "root mean square."
        gained = _gained(found, noise)
        drawn = forward_plot(samples, gained, diagnosis.units[gained])
        figures.append(figure(joint_words(gained, diagnosis.joints), found.run, drawn))
    if found.left_out:
        note += f" Not simulated: {', '.join(effect_words(one) for one in found.left_out)}."
    return section("simulation", "Simulation", paragraph(note), grid(*figures))


def _gained(found: Simulated, noise: np.ndarray) -> int:
    """The joint that gains most; where a simulation diverged there is no gain."""
    with np.errstate(over="ignore", invalid="ignore"):
        gains = (found.before**2 - found.after**2) / noise**2
    return int(np.argmax(np.nan_to_num(gains, nan=-np.inf)))


def _small(diagnosis: PageData) -> str:
    """Unit of a thousandth of a joint's way."""
    kinds = [name for name, unit in (("mrad", TURNING), ("mm", SLIDING)) if unit in diagnosis.units]
    return " or ".join(kinds)


def where_section(diagnosis: PageData) -> str:
    """Every joint against what it may depend on."""
    if not diagnosis.traces:
        return ""
    content = []
    for joint, name in enumerate(_names(diagnosis)):
        noise, unit = _noise(diagnosis, joint), diagnosis.units[joint]
        figures = [
            figure(f"over {axis}", "", profile_plot(diagnosis.traces, joint, AXES[axis], noise, unit))
            for axis in ("velocity", "position", "load")
        ]
        content += [heading(name), grid(*figures, kind="three alike")]
    note = "Residual of every joint, all runs: lines that are flat are a joint that is explained."
    return section("joints", "Every joint", paragraph(note), *content)


def data_section(diagnosis: PageData) -> str:
    """Runs, and what limits them."""
    held_out = ", ".join(diagnosis.improvement.runs) if diagnosis.improvement else "none"
    words = f"Fitted: {', '.join(diagnosis.runs)}; held out: {held_out}."
    warnings = diagnosis.warnings or ("Nothing about the recordings limits the result.",)
    return section("data", "Runs and what limits them", paragraph(words), listing(warnings))


def _names(diagnosis: PageData) -> list[str]:
    return [joint_words(joint, diagnosis.joints) for joint in range(len(diagnosis.joints))]


def _arrows(words: str) -> str:
    return words.replace("->", "\N{RIGHTWARDS ARROW}")


BELOW: tuple[Section, ...] = (findings_section, undecided_section, unexplained_section, moments_section)

SECTIONS: tuple[Section, ...] = (
    budget_section,
    verdict_section,
    *BELOW,
    changes_section,
    forward_section,
    where_section,
    data_section,
)
"""Of a page of its own."""

DETAILS = (budget_section, *BELOW, changes_section, where_section, data_section)
"""Of a page whose other sections give the verdict, and what was gained."""
