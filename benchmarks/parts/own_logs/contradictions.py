"""Numbers that a fit gives twice under one name, in text, page, JSON and robot.toml: whether they agree."""

import re
from collections.abc import Iterator, Mapping
from html.parser import HTMLParser
from itertools import combinations, takewhile
from typing import Any, NamedTuple

from exidyn.identification.model import Model

QUANTITIES = {
    "value": "value",
    "gain": "value",
    "± 95 %": "half",
    "std, %": "std %",
    "nominal": "nominal",
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
    "exported": "exported",
}
"""Heading of a column, without its unit -> the quantity, as it is compared."""
FIRST = ("name", "joint")
"""Heading of a table's first column."""
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
    """Numbers of the lines under a heading: of each table among them, which may stand below one another."""
    lasts = [place for place, line in enumerate(block) if line.split()[0] in FIRST and line[0] != " "]
    firsts = [_first_of_head(block, last) for last in lasts]
    for first, last, end in zip(firsts, lasts, [*firsts, len(block)][1:], strict=True):
        rows = [line for line in block[last + 1 : end] if re.match(r"\S+ {2,}.*\d", line)]
        if rows:
            yield from _in_table(block[first : last + 1], rows)


def _first_of_head(block: list[str], last: int) -> int:
    """Where a head begins that ends there: what is folded stands above, with nothing over the names."""
    above = takewhile(lambda line: line.startswith("   "), reversed(block[:last]))
    return last - len(list(above))


def _in_table(head: list[str], rows: list[str]) -> Iterator[Said]:
    """Numbers of one table, whose head may be folded, and whose columns are apart in every line."""
    lines = [*head, *rows]
    width = max(map(len, lines))
    blank = [all(not line[at : at + 1].strip() for line in lines) for at in range(width)]
    # A single blank may be one between the words of a head, under which no number reaches.
    around = [False, *blank, True]
    spans = _spans([one and (around[at] or around[at + 2]) for at, one in enumerate(blank)])
    if any(re.search(r"\d -?\d", row[span]) for row in rows for span in spans):
        spans = _spans(blank)
    names = [" ".join(line[span].strip() for line in head if line[span].strip()) for span in spans]
    for row in rows:
        yield from _row("text", names, [row[span].strip() for span in spans])


def _spans(blank: list[bool]) -> list[slice]:
    """Columns of a table, from where it is blank throughout."""
    starts = [at for at, empty in enumerate(blank) if not empty and (at == 0 or blank[at - 1])]
    return [slice(a, b) for a, b in zip(starts, [*starts[1:], None], strict=True)]


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
            if head[0] in FIRST and len(row) == len(head):
                yield from _row("page", head, row)


def in_fit(fit: Mapping[str, Any]) -> Iterator[Said]:
    """Numbers of fit.json; those of a single run that was fitted."""
    for one in fit["base_parameters"]:
        if one["kept"]:
            value, std = one["value"], one["std"]
            yield _exact("fit.json", one["name"], "value", value)
            yield _exact("fit.json", one["name"], "half", 1.96 * std)
            yield _exact("fit.json", one["name"], "std %", 100 * std / abs(value))
            if "exported" in one:
                yield _exact("fit.json", one["name"], "exported", one["exported"])
    names = {"over noise": "over_noise", "residual": "residual_rms", "noise": "noise", "R^2": "r_squared"}
    for quantity, key in names.items() if len(fit["agreement"]) == 1 else ():
        for joint, value in zip(fit["joints"], fit["agreement"][0][key], strict=True):
            yield _exact("fit.json", joint, quantity, value)
    for one in fit["unclear"]:
        yield _exact("fit.json's unclear", one["name"], "std %", one["std_percent"])


def in_robot(model: Model, fit: Mapping[str, Any]) -> Iterator[Said]:
    """Base parameters as sums of what a robot.toml of the fit has, those that the fit kept.

    Each is what the fit says is exported; and its value within its own 95 %, unless text, page and fit.json
    list it among those that no arm can have.
    """
    nominal = dict(zip(model.names, model.nominal_values, strict=True))
    for one in fit["base_parameters"]:
        if one["kept"] and set(one["sum_of"]) <= set(nominal):
            value = sum(share * nominal[name] for name, share in one["sum_of"].items())
            rounding = EXACT * max(abs(share * nominal[name]) for name, share in one["sum_of"].items())
            yield Said("robot.toml", one["name"], "exported", value, rounding)
            if one["name"] not in fit["moved"]:
                yield Said("robot.toml", one["name"], "value", value, 1.96 * one["std"])


def _exact(where: str, name: str, quantity: str, value: float) -> Said:
    return Said(where, name, quantity, value, 0.0)


def _row(where: str, head: list[str], row: list[str]) -> Iterator[Said]:
    for place, (heading, cell) in enumerate(zip(head, row, strict=False)):
        if heading in head[:place]:  # that of the nominal value
            continue
        unit = re.fullmatch(r"(residual|noise) \S+", heading)
        quantity = QUANTITIES.get(unit[1] if unit else heading)
        number = cell.replace("−", "-").removesuffix("*").strip()
        if quantity and re.fullmatch(r"-?\d+(\.\d*)?(e[+-]?\d+)?", number):
            digits, _, power = number.partition("e")
            half = 0.5 * 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))
            yield Said(where, row[0], quantity, float(number), half)
