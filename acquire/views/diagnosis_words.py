"""A diagnosis in Markdown, out of the tables of diagnosis.json."""

from typing import Any

import numpy as np

from exidyn.identify.diagnosis.findings.quantities import TURNING, with_interval
from exidyn.identify.diagnosis.words.misfit import from_table, lumped, percents, sentences
from exidyn.identify.diagnosis.words.naming import joint_words, named
from exidyn.identify.diagnosis.words.numbers import value_of
from exidyn.identify.text_table import digits


def verdict_markdown(table: dict[str, Any]) -> str:
    """The verdict as a list."""
    return "\n".join([f"## {table['name']}", *(f"- {line}" for line in table["verdict"])])


def parameters_markdown(table: dict[str, Any]) -> str:
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
