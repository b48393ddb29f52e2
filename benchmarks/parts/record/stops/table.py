"""Quick stops with wrong positions, on every driver: how far the arm moved, how long the loop was blocked."""

from collections.abc import Collection
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from common import show

from ..controllers import CONTROLLERS, NoBus
from .run import MOCK_FAULTS, Disturbed, Seen, seen

KINDS = tuple(MOCK_FAULTS)
ATTEMPTS = 3
QUICK = (("mock", "saturated"), ("can_mit", "exchanged"), ("dynamixel", "turned"))
"""What is shown in a hurry."""


def main(quick: bool, drivers: Collection[str] = ()) -> dict[str, Any]:
    cases = [(name, kind) for name in drivers or CONTROLLERS for kind in KINDS]
    runs: dict[tuple[str, str], Seen] = {}
    for name, kind in QUICK if quick and not drivers else cases:
        for _ in range(ATTEMPTS):
            try:
                with TemporaryDirectory() as folder:
                    runs[name, kind] = seen(name, kind, Path(folder))
                break
            except (Disturbed, NoBus) as error:
                print(f"{name}: {error}")
    rows = [
        [*case, run.beyond, 1e3 * run.block, run.stop[:60], run.told[:60] or "stands where it should"]
        for case, run in runs.items()
    ]
    show(
        "Quick stops with the position of a joint read wrongly",
        ["driver", "reading", "moved beyond rad", "block ms", "reason", "told at the end"],
        rows,
    )
    print("  moved beyond   motion that commands, tracking and the stopping distance do not explain")
    return {
        "stop_runs": len(runs),
        "stop_caused_motion": max((run.beyond for run in runs.values()), default=None),
        "stop_block_ms": max((1e3 * run.block for run in runs.values()), default=None),
    }
