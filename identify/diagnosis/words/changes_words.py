"""What each candidate alone would change, as lines of a table."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...text_table import paragraph, table
from ..findings.finding import Change, Diagnosis
from .naming import joint_words, named
from .numbers import number, value_of

TOP = 10
"""Rows on the text page; the report and the file have all."""
CHECK = (
    'To check a row: add it to robot.toml ([[effect]], name = "...", joints = ["..."]), run "exidyn identify '
    'RUNS --robot robot.toml --validate OTHER" with it and without, and compare the squares of the residuals '
    "held out. What is no effect of robot.toml (backlash, an elastic gear, a delay) cannot be checked so."
)


def lines(diagnosis: Diagnosis) -> list[str]:
    """The first rows, and how to check them; nothing where no candidate changes anything."""
    rows = [
        [
            named(one.effect, one.joints, diagnosis.joints),
            joint_words(one.joint, diagnosis.joints),
            shown(one),
        ]
        for one in diagnosis.changes[:TOP]
    ]
    if not rows:
        return []
    head = ["candidate, alone", "gains most", "squared error, %"]
    more = len(diagnosis.changes) - len(rows)
    rest = [f"and {more} more in report.html and diagnosis.json"] if more > 0 else []
    note = f"Of {source(diagnosis)}; +- one standard deviation over blocks. {CHECK}"
    return [*table(head, rows, left=(0, 1)), *rest, *paragraph(note)]


def source(diagnosis: Diagnosis) -> str:
    """Of which data the changes are."""
    return "runs held out" if diagnosis.improvement else "fitted runs, each block predicted by the others"


def shown(one: Change) -> str:
    """-31.2 +- 4.1."""
    std = f" +- {100 * one.std:.1f}" if np.isfinite(one.std) else ""
    return f"{100 * one.change:+.1f}{std}"


def as_table(changes: Sequence[Change]) -> list[dict[str, Any]]:
    """For diagnosis.json, joints from 1."""
    return [
        {
            "effect": one.effect,
            "joints": [joint + 1 for joint in one.joints],
            "joint": one.joint + 1,
            "squared_error_percent": number(100.0 * one.change),
            "std_percent": number(100.0 * one.std),
            "gain": number(one.gain),
        }
        for one in changes
    ]


def from_table(rows: Sequence[dict[str, Any]]) -> tuple[Change, ...]:
    """Read them back, of a table of the schema `DiagnosisFile`."""
    return tuple(
        Change(
            one["effect"],
            tuple(joint - 1 for joint in one["joints"]),
            one["joint"] - 1,
            value_of(one["squared_error_percent"]) / 100.0,
            value_of(one["std_percent"]) / 100.0,
            value_of(one["gain"]),
        )
        for one in rows
    )
