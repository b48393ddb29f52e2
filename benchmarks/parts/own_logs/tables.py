"""Tables and summary of what was found."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from common import show

from .statements import CERTAIN, SURE, Statement, calibration

Case = dict[str, Any]
"""Figures of one case, as JSON has them."""


def statements_of(cases: Sequence[Case]) -> list[Statement]:
    """All statements of some cases."""
    return [Statement(**statement) for case in cases for statement in case["statements"]]


def show_logs(logs: Sequence[Case]) -> None:
    """Tables of the right logs."""
    rows = []
    for case in logs:
        false = [one for one in statements_of([case]) if one.probability > CERTAIN and one.true is False]
        following = {None: "none", "": "works"}.get(case.get("next"), "FAILS")
        numbers = [
            len(false),
            len(case.get("open", [])),
            case.get("residual", np.nan),
            case["seconds"]["init"],
        ]
        rows.append([case["log"], following, *numbers])
    head = ["right log", "Next", "false", "open", "residual", "init CPU s"]
    show("From file and URDF to a fit, as init proposes", head, rows)
    for case in logs:
        following = f"Next: {case['next']}" if case.get("next") else ""
        for fault in filter(None, (case.get("failed"), following)):
            print(f"  {case['log']}: {fault}")


def show_recordings(sets: Sequence[Case]) -> None:
    """Table of the public recordings."""
    rows = []
    for case in sets:
        sure = [one for one in statements_of([case]) if one.probability > CERTAIN]
        verdicts = [one.true for one in sure]
        counts = [verdicts.count(verdict) for verdict in (True, None, False)]
        rows.append([case["set"], case["checked"], len(case["refused"]), *counts])
    head = ["recordings", "checked", "refused", "true > 95 %", "nobody knows", "false > 95 %"]
    show("Public recordings, as a whole, run by run, and in halves", head, rows)


def show_mistakes(cases: Sequence[Case]) -> None:
    """Table of the mistakes."""
    words = {True: "yes", False: "no"}
    rows = []
    for case in cases:
        false = [one for one in statements_of([case]) if one.probability > SURE and one.true is False]
        by = ", ".join(case["named_by"])
        rows.append([case["mistake"], words[case["named"]], by, words[case["physics_blamed"]], len(false)])
    head = ["mistake", "cure named", "by", "physics blamed", "false > 99 %"]
    show("Mistakes in a log", head, rows)
    for case in cases:
        if case.get("next"):
            print(f"  {case['mistake']}: Next: {case['next']}")


def show_statements(cases: Sequence[Case]) -> list[list[Any]]:
    """Table of stated probabilities; what is false of statements and refusals."""
    table = calibration(statements_of(cases))
    show("Statements with a probability, true and false", ["stated", "statements", "true", "true %"], table)
    for one in statements_of(cases):
        if one.probability > CERTAIN and one.true is False:
            print(f"  {one.where}: {one.text} ({100 * one.probability:.1f} %)")
    for case in cases:
        for refusal in case.get("refused", []):
            print(f"  refused: {refusal}")
    return table


def summary(sets: list[Case], logs: list[Case], right: list[Case], wrong: list[Case]) -> Case:
    """The figures of all cases."""
    good, every = [*sets, *logs, *right], [*sets, *logs, *right, *wrong]
    sure = [one for one in statements_of(every) if one.probability > SURE and one.true is not None]
    false = [one for one in statements_of(good) if one.probability > CERTAIN and one.true is False]
    following = [case["next"] for case in every if case.get("next") is not None]
    seconds = {
        case.get("log", case.get("set", case.get("mistake"))): case["seconds"].get("init", 0.0)
        for case in every
    }
    slowest = max(seconds, key=lambda name: seconds[name])
    return {
        "false_refusals": sum(len(case["refused"]) for case in good),
        "false_certain": len(false),
        "named_cure": sum(case["named"] for case in wrong),
        "of_mistakes": len(wrong),
        "physics_blamed": sum(case["physics_blamed"] for case in wrong),
        "certain_true_percent": 100 * float(np.mean([one.true for one in sure])) if sure else None,
        "of_certain": len(sure),
        "next_works": following.count(""),
        "of_next": len(following),
        "init_seconds_worst": seconds[slowest],
        "init_slowest": slowest,
        "init_fails": sum(case.get("failed", "").startswith("init") for case in logs),
        "of_logs": len(logs),
        "checked": sum(case["checked"] for case in sets),
    }
