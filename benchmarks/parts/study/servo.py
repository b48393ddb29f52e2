"""A servo that swings known masses: subsets of its recordings, none complete without its friction."""

from pathlib import Path
from typing import Any

from exidyn.acquire.commands.study_command import diagnose_step, identify_step
from exidyn.acquire.study.loop import Study
from exidyn.acquire.study.rounds import rounds
from exidyn.acquire.study.sources import Shelf
from exidyn.trajectories.next_run.choice import DECIDED

from ..diagnose_real.sets import kscale

NAMED = "load_dependent_friction"
"""What is known to be there: `KNOWN.md` beside the recordings."""
SUBSETS = {"one mass": ("m1168",), "two masses": ("m535", "m1168"), "all masses": ("",)}
"""Beginnings of the names of the recordings on offer."""


def of_subset(name: str, folder: Path) -> dict[str, Any]:
    """What a study of some of the recordings says."""
    model, runs = kscale()
    shelf = Shelf(tuple(run for _, run in runs if run.name.startswith(SUBSETS[name])))
    choice = Study(folder, model, shelf, 3600.0, identify_step, diagnose_step, {}).run()
    found = {effect for effect, _ in choice.findings}
    possible = {effect for effect, _ in choice.possible}
    decided = choice.verdict == DECIDED
    return {
        "found": sorted(found),
        "possible": sorted(possible),
        "verdict": choice.verdict,
        "runs": f"{len(rounds(folder))} of {len(shelf.recordings)}",
        "right": NAMED in found | possible,
        "false_decided": decided and NAMED not in found,
    }
