"""Told: `exidyn record` on controllers that misbehave, and every place that tells a person how it ended."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from common import show

from tests.parts.runs.told import CASES, attempted

from .controllers import NoBus

MOVES = {True: "moves", None: "nobody knows", False: "stands"}


def main(quick: bool) -> dict[str, Any]:
    rows, silent, repeated, failed, waited, blocks = [], 0, 0, [], [0.0], [0.0]
    for case in CASES:
        if quick and not case.quick:
            continue
        try:
            with TemporaryDirectory() as folder:
                seen, places, bad, attempts = attempted(case, Path(folder))
        except NoBus as error:
            print(f"{case.name}: {error}")
            continue
        silent += bool(places)
        failed += [case.name] * bool(bad)
        repeated += attempts > 1
        words = "; ".join([*places, *bad]) or "told"
        first, block = 1e3 * max(seen.waited, default=0.0), 1e3 * seen.table.get("longest_block", 0.0)
        if first < 0.0:  # the recording's times are those of a clock that stands still
            first = float("nan")
        if not case.pauses:
            waited += [first] if first == first else []
            blocks.append(block)
        rows.append([case.name, MOVES[case.moves], " ".join(seen.levels), words, first, block, attempts])
    columns = ["controller", "arm", "stops", "", "first word ms", "block ms", "attempts"]
    show("What a person is told of an arm, at once and at the end", columns, rows)
    print("  told      by the terminal's last line, page, exit code, JSON, recording and exidyn info")
    return {
        "told": len(rows),
        "untold": silent,
        "first_word_ms": max(waited),
        "longest_block_ms": max(blocks),
        "told_repeated": repeated,
        "told_failed": len(failed),
        "told_failed_names": failed,
    }
