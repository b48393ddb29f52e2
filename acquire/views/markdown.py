"""A fit, and a diagnosis out of the tables of diagnosis.json, in Markdown."""

from typing import Any

import numpy as np

from exidyn.identify.diagnosis.findings.quantities import TURNING, with_interval
from exidyn.identify.diagnosis.words.misfit import from_table, lumped, percents, sentences
from exidyn.identify.diagnosis.words.naming import joint_words, named
from exidyn.identify.diagnosis.words.numbers import value_of
from exidyn.identify.fit.fit import Fit
from exidyn.identify.fit.verdict import NORMAL_95, gains_estimated, verdict
from exidyn.identify.pages.report_html import rounded
from exidyn.identify.text_table import digits


def fit_verdict(fit: Fit) -> str:
    """The verdict as a list."""
    return "\n".join(["## Verdict", *(f"- {line}" for line in verdict(fit))])


def parameters_markdown(fit: Fit) -> str:
    """Gains and parameters as Markdown tables."""
    estimate, (nominal, deviation) = fit.estimate, fit.prior
    lines = ["## Drive gains", "| joint | gain | \u00b1 95 % | nominal |", "|---|---|---|---|"]
    for k, (joint, stated) in enumerate(zip(fit.model.robot.joints, fit.model.robot.drive_gain, strict=True)):
        half = rounded(NORMAL_95 * estimate.gain_std[k], 2) if gains_estimated(fit) else "as stated"
        gain = "not stated" if fit.gains_unstated else rounded(stated)
        half = "unknown" if fit.unscaled else half
        lines.append(f"| {joint} | {rounded(estimate.gain[k], 5)} | {half} | {gain} |")
    lines += [
        "## Parameters",
        "| | parameter | value | \u00b1 95 % | "
        + (f"unit per {', '.join(dict.fromkeys(fit.model.robot.units('N m/A')))}" if fit.unscaled else "unit")
        + " | nominal |",
        "|---|---|---|---|---|---|",
    ]
    for k, (name, unit) in enumerate(zip(fit.names, fit.base.units, strict=True)):
        prior = (
            f"{rounded(nominal[k])} \u00b1 {rounded(deviation[k], 2)}"
            if np.isfinite(deviation[k]) and not fit.unscaled
            else ""
        )
        value, half = rounded(estimate.values[k], 5), rounded(NORMAL_95 * estimate.std[k], 2)
        lines.append(f"| {k} | {name} | {value} | {half} | {unit} | {prior} |")
    return "\n".join(lines)


def diagnosis_verdict(table: dict[str, Any]) -> str:
    """The verdict as a list."""
    return "\n".join([f"## {table['name']}", *(f"- {line}" for line in table["verdict"])])


def findings_markdown(table: dict[str, Any]) -> str:
    """What was found, with intervals, and what it might be instead."""
    every = [*table["findings"], *table.get("undecided", ())]
    if not every:
        return "Nothing was found that has parameters."
    lines = []
    for finding in every:
        lines += [f"## {finding_name(table, finding)}", f"{finding['sentence']}.", ""]
        lines += ["| parameter | value ± 95 % | unit |", "|---|---|---|"]
        for name, quantity in finding["parameters"].items():
            value, std = (value_of(quantity[key]) for key in ("value", "std"))
            unit = "" if quantity["unit"] == "1" else quantity["unit"]
            lines.append(f"| {name} | {with_interval(value, std)} | {unit} |")
        lines += ["", f"Probability {100 * finding['probability']:.4g} %.", ""]
        lines += [
            f"- not excluded: {finding_name(table, other)}, {100 * value_of(other['probability']):.2g} %"
            for other in finding["alternatives"]
        ]
        lines.append("")
    return "\n".join(lines)


def budget_markdown(table: dict[str, Any]) -> str:
    """Where the misfit goes, joint by joint."""
    if not table.get("budget"):
        return "This diagnosis came without a budget."
    found = lumped(from_table(table["budget"], table["joints"]))
    whole = percents(np.array([part.shares for part in found.parts]))
    lines = [f"| | {' | '.join(found.joints)} |", f"|---|{'---|' * len(found.joints)}"]
    for name, values in (("before", found.before), ("after", found.after)):
        cells = [f"{digits(value)} {unit}" for value, unit in zip(values, found.units, strict=True)]
        lines.append(f"| misfit {name} | {' | '.join(cells)} |")
    for part, own in zip(found.parts, whole, strict=True):
        lines.append(f"| {part.name} | {' | '.join(f'{value} %' for value in own)} |")
    return "\n".join([*lines, "", *(f"- {line}" for line in sentences(found))])


def residuals_markdown(table: dict[str, Any]) -> str:
    """Held-out residual of every joint before and after, over noise as well where that was measured."""
    if not table.get("noise"):
        return "No run was held out."
    over = table.get("noise_measured_at_rest", True)
    head = ["joint", "before", "after", *(["noise", "before / noise", "after / noise"] if over else [])]
    lines = [f"| {' | '.join(head)} |", f"|{'---|' * len(head)}"]
    rows = zip(table["noise"], table["torque_rms_before"], table["torque_rms_after"], strict=True)
    units = table.get("torque_units", [TURNING] * len(table["joints"]))
    for joint, row in enumerate(rows):
        noise, before, after = map(value_of, row)
        cells = [joint_words(joint, table["joints"])]
        cells += [f"{digits(value)} {units[joint]}" for value in (before, after, noise)[: 3 if over else 2]]
        cells += [f"{before / noise:.3g}", f"{after / noise:.3g}"] if over else []
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def finding_name(table: dict[str, Any], finding: dict[str, Any]) -> str:
    """An effect and where it acts: Load dependent friction of joint 3."""
    return named(finding["effect"], [joint - 1 for joint in finding["joints"]], table["joints"])
