"""Tables of scores, and their figures: of one way to answer, or of several beside each other."""

from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from common import show

from exidyn.identification.diagnosis.candidates import kinds

from .score import (
    NOTHING,
    UNEXPLAINED,
    Pair,
    alarmed,
    coverage_rows,
    covered,
    diagnosed_numbers,
    figures,
    of_kind,
    precise,
    share,
    top1,
    visible,
)

STRENGTHS = (0.0, 0.5, 1.0, 2.0, 5.0, np.inf)
CONFIDENCES = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0 + 1e-9)


def calibration(cases: list[Pair]) -> list[list[Any]]:
    """Stated probability against the share that was right: from, to, findings, mean stated, right."""
    stated = [
        (found.confidence, right)
        for case in cases
        for found, right in zip(case.answer.findings, precise(case), strict=True)
    ]
    return classes(stated)


def classes(stated: list[tuple[float, bool]]) -> list[list[Any]]:
    """Pairs of a stated probability and whether it was right, by classes of the first."""
    rows: list[list[Any]] = []
    for low, high in zip(CONFIDENCES, CONFIDENCES[1:], strict=False):
        inside = [pair for pair in stated if low <= pair[0] < high]
        if inside:
            rows.append([low, min(high, 1.0), len(inside), *np.mean(inside, axis=0)])
    return rows


def by_strength(cases: list[Pair]) -> list[list[Any]]:
    """Detectable singles by visibility: from, to, cases, top 1, with alternatives, reported as nothing."""
    rows: list[list[Any]] = []
    for low, high in zip(STRENGTHS, STRENGTHS[1:], strict=False):
        inside = [
            case
            for case in of_kind(cases, "single")
            if visible(case) and low <= case.truth.visibility[0] < high
        ]
        if inside:
            silent = share(not alarmed(case) for case in inside)
            rows.append(
                [low, high, len(inside), share(map(top1, inside)), share(map(covered, inside)), silent]
            )
    return rows


def confusion(cases: list[Pair]) -> list[list[Any]]:
    """What singles, outside and nothing were called: truth, called, times; agreement left out."""
    counts: Counter[tuple[str, str]] = Counter()
    for truth, answer in cases:
        if truth.kind == "double":
            continue
        name = truth.effects[0].effect if truth.effects else NOTHING
        right = top1(Pair(truth, answer)) if truth.kind == "single" else answer.called == (
            UNEXPLAINED if truth.kind == "outside" else NOTHING
        )  # fmt: skip
        if not right:
            wrong_joint = truth.kind == "single" and answer.called == name
            counts[name, "the same, on another joint" if wrong_joint else answer.called] += 1
    return [[name, called, times] for (name, called), times in sorted(counts.items())]


def outside(cases: list[Pair]) -> list[list[Any]]:
    """Cases outside the vocabulary, of kinds that are asked for all the same and of others.

    Returns:
        Of both: which, cases, share misnamed, share reported as unexplained.
    """
    asked, rows = kinds(), []
    every = of_kind(cases, "outside")
    for which, known in (("has a candidate", True), ("has none", False)):
        own = [case for case in every if (case.truth.effects[0].effect in asked) == known]
        misnamed = share(bool(case.answer.findings) for case in own)
        rows.append([which, len(own), misnamed, share(case.answer.unexplained for case in own)])
    return rows if every else []


def coverage(cases: list[Pair]) -> list[list[Any]]:
    """Diagnosed numbers whose truth is known: how many, whose 95 % interval contains it, and their errors."""
    return coverage_rows(number for case in cases for number in diagnosed_numbers(case))


class Table(NamedTuple):
    """One table of scores, by what its rows are made."""

    title: str
    header: tuple[str, ...]
    rows: Callable[[list[Pair]], list[list[Any]]]


TABLES = {
    "outside": Table(
        "outside the vocabulary", ("the diagnosis", "cases", "misnamed", "unexplained"), outside
    ),
    "by_strength": Table(
        "by strength (effect over noise)",
        ("from", "to", "cases", "top 1", "with alternatives", "silent"),
        by_strength,
    ),
    "calibration": Table("stated probabilities", ("from", "to", "findings", "stated", "right"), calibration),
    "coverage": Table(
        "95 % intervals of diagnosed numbers (medians; error over std is a root mean square)",
        ("effect", "number", "count", "contained %", "error %", "half interval %", "error / std"),
        coverage,
    ),
    "confusion": Table("called otherwise", ("truth", "called", "times"), confusion),
}
"""In the order in which they are printed."""


def print_scores(answered: Mapping[str, list[Pair]]) -> dict[str, Any]:
    """Print every table, each way to answer beside the others.

    Returns:
        Figures and tables by name: those of the first way, and those of each other under its name.
    """
    several = len(answered) > 1
    numbers = {who: figures(cases) for who, cases in answered.items()}
    tables = {who: {name: one.rows(cases) for name, one in TABLES.items()} for who, cases in answered.items()}
    first, *others = answered
    rows = [[name, *(found[name] for found in numbers.values())] for name in numbers[first]]
    show("concealed cases", ["figure", *(answered if several else ["value"])], rows)
    for name, table in TABLES.items():
        rows = [[who, *row] if several else row for who in answered for row in tables[who][name]]
        if rows:
            show(table.title, ["answered", *table.header] if several else table.header, rows)
    return numbers[first] | tables[first] | {who: numbers[who] | tables[who] for who in others}
