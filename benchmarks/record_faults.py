"""Faults on purpose: what must happen, argued from what moves, and what happened."""

from collections.abc import Sequence
from typing import Any

from common import show
from record_controllers import NoBus
from record_fault import Row, shown
from record_fault_cases import FAULTS
from record_fault_files import file_faults


def table(rows: Sequence[Row]) -> dict[str, Any]:
    """Print what became of all faults; the figures."""
    show("Faults", ["fault", "must", "happened", ""], [row.cells for row in rows])
    failed = [row.name for row in rows if row.wrong]
    return {"faults": len(rows), "faults_failed": len(failed), "faults_failed_names": failed}


def main(quick: bool) -> dict[str, Any]:
    rows = []
    for fault in FAULTS:
        if fault.quick or not quick:
            try:
                rows.append(shown(fault))
            except NoBus as error:
                print(f"{fault.name}: {error}")
    return table([*rows, *file_faults(quick)])
