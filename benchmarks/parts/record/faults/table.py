"""Faults on purpose: what must happen, argued from what moves, and what happened."""

from collections.abc import Collection, Sequence
from typing import Any

from common import show

from ..controllers import NoBus
from .cases import FAULTS
from .fault import Fault, Row, shown
from .files import file_faults

ATTEMPTS = 3
"""At a fault: a machine that misses ten milliseconds by itself has another fault than the one in question."""


def attempted(fault: Fault) -> Row:
    """Let it happen, again where something went wrong; the row has how often."""
    for attempt in range(1, ATTEMPTS + 1):
        row = shown(fault)
        if not row.wrong:
            break
        print(f"{fault.name}: attempt {attempt}: {'; '.join(row.wrong)}")
    row.cells.append(attempt)
    return row


def table(rows: Sequence[Row]) -> dict[str, Any]:
    """Print what became of all faults; the figures."""
    show("Faults", ["fault", "must", "happened", "", "attempts"], [[*row.cells, 1][:5] for row in rows])
    failed = [row.name for row in rows if row.wrong]
    again = sum(row.cells[4] > 1 for row in rows if len(row.cells) > 4)
    return {
        "faults": len(rows),
        "faults_repeated": again,
        "faults_failed": len(failed),
        "faults_failed_names": failed,
    }


def main(quick: bool, drivers: Collection[str] = ()) -> dict[str, Any]:
    rows = []
    for fault in FAULTS:
        if fault.driver in drivers if drivers else fault.quick or not quick:
            try:
                rows.append(attempted(fault))
            except NoBus as error:
                print(f"{fault.name}: {error}")
    return table(rows if drivers else [*rows, *file_faults(quick)])
