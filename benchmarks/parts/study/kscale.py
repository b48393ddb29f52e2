"""A servo that swings known masses: the same choices among recordings that exist."""

from pathlib import Path
from typing import Any

from exidyn.acquire.commands.study_command import diagnose_step, identify_step
from exidyn.acquire.study.loop import Study
from exidyn.acquire.study.rounds import rounds
from exidyn.acquire.study.shelf import Shelf

from ..diagnose_real.sets import kscale

ONE = "m1168"
"""The mass of the subset; the nominal servo swings another."""
NAMED = "load_dependent_friction"
MINUTES, QUICK = 1.0, 0.15
"""Of motion, at most."""


def chosen_among(folder: Path, wanted: str = "", minutes: float = MINUTES) -> dict[str, Any]:
    """A study of the recordings whose names begin as wanted: runs in their order, findings and verdict."""
    model, runs = kscale()
    shelf = Shelf(tuple(run for _, run in runs if run.name.startswith(wanted)))
    choice = Study(folder, model, shelf, 60.0 * minutes, identify_step, diagnose_step, {}).run()
    every = rounds(folder)
    return {
        "runs": [one.recording().name for one in every],
        "named": [[effect for effect, _ in table["findings"]] for one in every if (table := one.choice)],
        "verdict": choice["verdict"],
        "remains": choice["remains"],
    }
