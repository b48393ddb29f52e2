"""A diagnosis in Markdown, out of the tables of diagnosis.json."""

from typing import Any

from exidyn.identify.diagnosis.quantities import with_interval
from exidyn.identify.diagnosis.sentences import joint_words
from exidyn.identify.diagnosis.words import named
from exidyn.identify.text_table import digits


def verdict_markdown(table: dict[str, Any]) -> str:
    """The verdict as a list."""
    return "\n".join([f"## {table['name']}", *(f"- {line}" for line in table["verdict"])])


def parameters_markdown(table: dict[str, Any]) -> str:
    """What was found, with intervals, and what it might be instead."""
    if not table["findings"]:
        return "Nothing was found that has parameters."
    lines = []
    for finding in table["findings"]:
        lines += [f"## {finding_name(table, finding)}", f"{finding['sentence']}.", ""]
        lines += ["| parameter | value ± 95 % | unit |", "|---|---|---|"]
        for name, quantity in finding["parameters"].items():
            value, std = (_number(quantity[key]) for key in ("value", "std"))
            unit = "" if quantity["unit"] == "1" else quantity["unit"]
            lines.append(f"| {name} | {with_interval(value, std)} | {unit} |")
        lines += ["", f"Probability {100 * finding['probability']:.4g} %.", ""]
        lines += [
            f"- not excluded: {finding_name(table, other)}, {100 * _number(other['probability']):.2g} %"
            for other in finding["alternatives"]
        ]
        lines.append("")
    return "\n".join(lines)


def residuals_markdown(table: dict[str, Any]) -> str:
    """Held-out residual of every joint over its noise, before and after."""
    if not table.get("noise"):
        return "No run was held out."
    lines = ["| joint | noise [N m] | before / noise | after / noise |", "|---|---|---|---|"]
    rows = zip(table["noise"], table["torque_rms_before"], table["torque_rms_after"], strict=True)
    for joint, row in enumerate(rows):
        noise, before, after = map(_number, row)
        name = joint_words(joint, table["joints"])
        lines.append(f"| {name} | {digits(noise)} | {before / noise:.3g} | {after / noise:.3g} |")
    return "\n".join(lines)


def finding_name(table: dict[str, Any], finding: dict[str, Any]) -> str:
    """An effect and where it acts: Load dependent friction of joint 3."""
    return named(finding["effect"], [joint - 1 for joint in finding["joints"]], table["joints"])


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)
