"""Repeatability in words and a table: which parameters agree between runs, and what the others follow."""

import numpy as np

from ..document.document import Block, Number, Paragraph, Row, Section, Statements, Table
from ..fit.fit_warnings import OPEN
from ..fit.repeatability import FEWEST, SHORTEST, SPEED, TEMPERATURE, TIME, Repeatability, Repeated
from ..text_table import NORMAL_95, digits, percent

UNITS = {SPEED: "rad/s", TEMPERATURE: "\N{DEGREE SIGN}C", TIME: "min"}
"""Units of the conditions; settings have none."""


def repeatability_section(repeatability: Repeatability, unit: str) -> Section:
    """How many parameters agree, and a table of those that differ under the head `unit`."""
    blocks: list[Block] = [Statements([agreement_sentence(repeatability)])]
    if repeatability.differing:
        note = (
            "Between: standard deviation between parts beyond that of the estimates. Probability: that of at "
            "least this scatter if the parameter is the same in all parts. Follows: conditions that explain "
            "the differences, each by itself, with the change per unit."
        )
        rows: list[Row] = [_row(parameter, repeatability) for parameter in repeatability.differing]
        head = ["parameter", "mean", "between", unit, "between, %", "probability", "follows"]
        blocks += [Paragraph(note), Table(head, rows, words=(3, 5, 6))]
    return Section("repeatability", "Repeatability", blocks)


def agreement_sentence(repeatability: Repeatability) -> str:
    """Number of parts, of parameters, and of those that agree."""
    parts, count = repeatability.parts, len(repeatability.parameters)
    if len(parts) < 2:
        return f"Nothing to compare: this needs two runs, or parts of a run, of {SHORTEST:g} s each."
    if not count:
        return "No part alone determines a base parameter: record longer runs that move all joints."
    runs = len({part.run for part in parts})
    split = f"{runs} runs" if runs == len(parts) else f"{len(parts)} parts of {runs} run{'s' * (runs > 1)}"
    differing = len(repeatability.differing)
    known = sum(_determined(parameter) for parameter in repeatability.parameters)
    seen = (
        f"A part alone determines {known} of the {count} to {OPEN:g} % or better; of the others, only larger "
        "differences would be seen."
    )
    if not differing:
        return (
            f"All {count} base parameters agree between {split}, each fitted alone: they scatter as their "
            f"intervals say. {seen}"
        )
    return (
        f"{count - differing} of {count} base parameters agree between {split}, each fitted alone; "
        f"{differing} scatter{'s' * (differing == 1)} more than their intervals say. {seen}"
    )


def _determined(parameter: Repeated) -> bool:
    """Whether the median standard deviation of the parts is below `OPEN` percent of the mean."""
    std = [value for value in parameter.std if value is not None]
    return bool(100 * np.median(std) <= OPEN * abs(parameter.mean))


def _row(parameter: Repeated, repeatability: Repeatability) -> Row:
    relative = 100 * parameter.deviation / abs(parameter.mean) if parameter.mean else float("nan")
    return [
        parameter.name, Number(parameter.mean), Number(parameter.deviation, 2), parameter.unit,
        Number(relative, 2), percent(parameter.probability), _follows(parameter, repeatability),
    ]  # fmt: skip


def _follows(parameter: Repeated, repeatability: Repeatability) -> str:
    """Conditions with the change of the parameter per unit."""
    if trends := parameter.follows:
        return "; ".join(
            f"{trend.condition}, {digits(trend.slope, 3)} ± {digits(NORMAL_95 * trend.std, 2)} per "
            f"{UNITS.get(trend.condition, 'unit')}"
            for trend in trends
        )
    if len(repeatability.parts) < FEWEST:
        return f"undecided: {FEWEST} parts are needed"
    return f"not {' or '.join(repeatability.conditions)}"
