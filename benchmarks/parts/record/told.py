"""Told: `exidyn record` on controllers that misbehave, and every place that tells a person how it ended."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from common import show

from tests.parts.runs.told import CASES, Case, told, untold, wrong

from .controllers import NoBus

MOVES = {True: "moves", None: "nobody knows", False: "stands"}
ATTEMPTS = 3
"""At a case: a machine that misses ten milliseconds by itself stops the run for another reason."""


def main(quick: bool) -> dict[str, Any]:
    rows, silent, failed = [], 0, []
    for case in CASES:
        if quick and not case.quick:
            continue
        try:
            levels, places, bad = _attempted(case)
        except NoBus as error:
            print(f"{case.name}: {error}")
            continue
        silent += bool(places)
        failed += [case.name] * bool(bad)
        rows.append([case.name, MOVES[case.moves], " ".join(levels), "; ".join([*places, *bad]) or "told"])
    show("What a person is told of an arm at the end", ["controller", "arm", "stops", ""], rows)
    print("  told      by the terminal's last line, page, exit code, JSON, recording and exidyn info")
    return {"told": len(rows), "untold": silent, "told_failed": len(failed), "told_failed_names": failed}


def _attempted(case: Case) -> tuple[tuple[str, ...], list[str], list[str]]:
    """Stops, places that do not tell, and what else is wrong; again where the machine was the cause."""
    for _ in range(ATTEMPTS):
        with TemporaryDirectory() as folder:
            seen = told(case, Path(folder))
        result = seen.levels, untold(case, seen), wrong(case, seen)
        if not (result[1] or result[2]):
            break
    return result
