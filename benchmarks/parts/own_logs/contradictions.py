"""Numbers that a fit gives twice under one name, in text, page, JSON and robot.toml: whether they agree."""

import re
from collections.abc import Iterator, Mapping
from html.parser import HTMLParser
from itertools import combinations, takewhile
from typing import Any, NamedTuple

from exidyn.identify.model import Model

QUANTITIES = {
    "value": "value",
    "std %": "std %",
    "nominal": "nominal",
    "+- std": "std of nominal",
    "± std": "std of nominal",
    "from": "from",
    "to (95%)": "to",
    "over noise": "over noise",
    "residual / noise": "over noise",
    "residual": "residual",
    "residual rms": "residual",
    "noise": "noise",
    "relative %": "relative %",
    "residual, % of torque": "relative %",
    "R^2": "R^2",
    "R²": "R^2",
    "correlation": "correlation",
}
"""Heading of a column, without its unit -> the quantity, as it is compared."""
EXACT = 1e-6
"""Relative difference of two numbers that are written in full."""


class Said(NamedTuple):
    """One number.

    Attributes:
        where: Output that has it.
        name: Of a parameter or a joint.
        quantity: One of `QUANTITIES`.
        value: As written.
        half: Half of its last digit: how far from it the number may be that was meant.
    """

    where: str
    name: str
    quantity: str
    value: float
    half: float


def contradictions(said: list[Said]) -> tuple[list[str], int]:
    """What does not agree, a sentence a name and quantity, and how many of these were compared."""
    by_name: dict[tuple[str, str], list[Said]] = {}
    for one in said:
        by_name.setdefault((one.name, one.quantity), []).append(one)
    found, compared = [], 0
    for (name, quantity), ones in by_name.items():
        pairs = [(a, b) for a, b in combinations(ones, 2) if a.where != b.where]
        compared += bool(pairs)
        for a, b in pairs:
            if abs(a.value - b.value) > a.half + b.half + EXACT * max(abs(a.value), abs(b.value)):
                found.append(f"{quantity} of {name}: {a.value:g} in {a.where}, {b.value:g} in {b.where}")
                break
    return found, compared


def in_text(text: str) -> Iterator[Said]:
    """Numbers of the tables that `exidyn identify` prints; those of the runs that were fitted."""
    lines = text.splitlines()
    for place, line in enumerate(lines):
        if line and set(line) == {"-"}:
            block = list(
                takewhile(lambda one: one.strip() and not one.startswith("validated on"), lines[place + 1 :])
            )
            yield from _in_block(block)


def _in_block(block: list[str]) -> Iterator[Said]:
    """Numbers of one table, whose head may be folded, and whose columns are apart in every line."""
    ends = [place for place, line in enumerate(block) if line[:1].strip() and len(line.split()) > 3]
    head = block[: ends[0] + 1] if ends else []
    rows = [line for line in block[len(head) :] if line.startswith("  ") and len(line.split()) > 4]
    if not rows or any(line[:1].strip() for line in head[:-1]):
        return
    width = max(map(len, block))
    blank = [all(not line[at : at + 1].strip() for line in (*head, *rows)) for at in range(width)]
    starts = [at for at in range(width) if not blank[at] and (at == 0 or blank[at - 1])]
    spans = [slice(a, b) for a, b in zip(starts, [*starts[1:], None], strict=True)]
    names = [" ".join(line[span].strip() for line in head if line[span].strip()) for span in spans]
    for row in rows:
        yield from _row("text", names, [row[span].strip() for span in spans])


class _Tables(HTMLParser):
    """Cells of all tables of a page, as they are shown."""

    def __init__(self) -> None:
        super().__init__()
        self.tables: list[list[list[str]]] = []
        self.cell: list[str] | None = None

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in ("td", "th"):
            self.cell = []

    def handle_endtag(self, tag: str) -> None:
        if tag in ("td", "th") and self.cell is not None:
            self.tables[-1][-1].append("".join(self.cell).strip())
            self.cell = None

    def handle_data(self, data: str) -> None:
        if self.cell is not None:
            self.cell.append(data)


def in_page(page: str) -> Iterator[Said]:
    """Numbers of the tables of report.html, as a reader sees them; what was dropped has no value there."""
    reader = _Tables()
    reader.feed(page)
    for head, *rows in filter(None, reader.tables):
        for row in rows:
            if head[0] in ("joint", "parameter") and "value it had" not in head:
                yield from _row("page", head, row)


def in_fit(fit: Mapping[str, Any]) -> Iterator[Said]:
    """Numbers of fit.json; those of a single run that was fitted."""
    for one in fit["base_parameters"]:
        if one["kept"]:
            value, std = one["value"], one["std"]
            yield _exact("fit.json", one["name"], "value", value)
            yield _exact("fit.json", one["name"], "std %", 100 * std / abs(value))
    names = {"over noise": "over_noise", "residual": "residual_rms", "noise": "noise", "R^2": "r_squared"}
    for quantity, key in names.items() if len(fit["agreement"]) == 1 else ():
        for joint, value in zip(fit["joints"], fit["agreement"][0][key], strict=True):
            yield _exact("fit.json", joint, quantity, value)
    for one in fit["unclear"]:
        yield _exact("fit.json's unclear", one["name"], "std %", one["std_percent"])


def in_robot(model: Model, fit: Mapping[str, Any]) -> Iterator[Said]:
    """Base parameters as sums of what a robot.toml of the fit has, those that the fit kept.

    A robot.toml has bodies that can exist, which the fit's need not: within the fit's own 95 % they agree.
    """
    nominal = dict(zip(model.names, model.nominal_values, strict=True))
    for one in fit["base_parameters"]:
        if one["kept"] and set(one["sum_of"]) <= set(nominal):
            value = sum(share * nominal[name] for name, share in one["sum_of"].items())
            yield Said("robot.toml", one["name"], "value", value, 1.96 * one["std"])


def _exact(where: str, name: str, quantity: str, value: float) -> Said:
    return Said(where, name, quantity, value, 0.0)


def _row(where: str, head: list[str], row: list[str]) -> Iterator[Said]:
    for heading, cell in zip(head, row, strict=False):
        unit = re.fullmatch(r"(residual|noise) \S+", heading)
        quantity = QUANTITIES.get(unit[1] if unit else heading)
        number = cell.replace("−", "-").removesuffix("*").strip()
        if quantity and re.fullmatch(r"-?\d+(\.\d*)?(e[+-]?\d+)?", number):
            digits, _, power = number.partition("e")
            half = 0.5 * 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))
            yield Said(where, row[0], quantity, float(number), half)
