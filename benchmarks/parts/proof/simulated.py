"""Section of docs/proof.md: what benchmarks/concealed.py scored on simulated arms."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .texts import SIMULATED
from .words import table

WAYS = {"product": "values stated", "bare": "no values stated"}
"""Who answered -> heading."""


def simulated_section(file: Path | None) -> str:
    """What was found again, by a file of `concealed.py --json`; without one, where to count it."""
    if file is None:
        return SIMULATED
    saved = json.loads(file.read_text())
    scores = {"product": saved} | {who: saved[who] for who in WAYS if who in saved}
    header = ["", *(WAYS[who] for who in scores)]
    rows = [[name, *(words(score) for score in scores.values())] for name, words in ROWS.items()]
    return f"{SIMULATED}\n{table(header, rows)}\n{otherwise(saved)}"


def _percent(key: str) -> Callable[[dict[str, Any]], str]:
    return lambda score: f"{100 * score[key]:.0f} %"


ROWS: dict[str, Callable[[dict[str, Any]], str]] = {
    "cases": lambda score: str(score["cases"]),
    "single effects large enough to be seen": lambda score: str(score["detectable"]),
    "of these, named, on the right joint, first": _percent("top1"),
    "of these, named or among the alternatives": _percent("with_alternatives"),
    "nothing missing, and something named": lambda score: (
        f"{score['false_alarms']} of {score['nothing_cases']} cases"
    ),
    "two effects: found": _percent("double_recall"),
    "two effects: right of what is named": _percent("double_precision"),
    "an effect without a model here: something else named": _percent("outside_misnamed"),
}
"""Row of the table -> its words."""


def otherwise(score: dict[str, Any]) -> str:
    """Singles that were called otherwise, cases without an effect that were named, each with its number."""
    called = [f"{truth} as {name} ({times})" for truth, name, times in score["confusion"]]
    text = "; ".join(called).replace("_", " ")
    return f"Of all strengths, called otherwise: {text or 'nothing'}.\n"
