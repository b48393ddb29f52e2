"""A servo that swings known masses: studied with one of them, then with recordings of others on offer too."""

from pathlib import Path
from typing import Any

from exidyn.acquire.commands.study_command import diagnose_step, identify_step
from exidyn.acquire.study.loop import Study
from exidyn.acquire.study.rounds import forget_end, rounds
from exidyn.acquire.study.sources import Shelf

from ..diagnose_real.sets import kscale

ONE = "m1168"
"""The mass of the first recordings; the nominal servo swings another."""
NAMED = "load_dependent_friction"
MINUTES, QUICK = 1.0, 0.6
"""Of motion, at most: the recordings of one mass, and six of others, or two."""


def asked_for(folder: Path, minutes: float = MINUTES) -> dict[str, Any]:
    """What one mass leaves open, which recording is then chosen, and whether others settle it."""
    model, runs = kscale()
    for wanted in (ONE, ""):
        shelf = Shelf(tuple(run for _, run in runs if run.name.startswith(wanted)))
        asked = {"recordings": wanted}
        forget_end(folder, asked)
        study = Study(folder, model, shelf, 60.0 * minutes, identify_step, diagnose_step, asked)
        choice = study.run()
        if wanted:
            alone, number = choice, len(rounds(folder))
    every = rounds(folder)
    names = [one.recording().name for one in every]
    after = [_named(one.choice or {"findings": []}) for one in every[number:]]
    return {
        "one mass": _named(alone),
        "verdict": alone["verdict"],
        "remains": alone["remains"],
        "asked for another mass": names[number : number + 1] != [] and ONE not in names[number],
        "runs": names,
        "all masses": _named(choice),
        "settled by the run asked for": NAMED not in _named(alone) and NAMED in after[0],
        "settled in rounds behind it": sum(NAMED in one for one in after),
        "rounds behind it": len(after),
    }


def _named(choice: dict[str, Any]) -> list[str]:
    return [effect for effect, _ in choice["findings"]]
