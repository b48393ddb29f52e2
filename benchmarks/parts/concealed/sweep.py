"""The strength at which an effect is found half of the time, over the noise floor."""

import shutil
from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from common import show

from .answerers import Answerer
from .case import Draw, make
from .effects.vocabulary import VOCABULARY
from .robots.arms import ARMS
from .scoring.answers import read_answer, read_truth
from .scoring.half_way import BOUNDS, half_way
from .scoring.score import Pair, recalled

STEP = 1.7
"""Factor between one strength and the next: weaker after it was found, stronger after it was missed."""


def sweep(
    effects: list[str],
    trials: int,
    seed: int,
    folder: Path,
    answer: Callable[[Path], Answerer],
    pool: Executor,
) -> dict[str, Any]:
    """Print and give the strength at which each effect is found half of the time.

    Args:
        effects: Names of the vocabulary.
        trials: Cases of each.
        seed: Of the first.
        folder: Where cases and truths go, and are deleted again.
        answer: Gives the answerer of a folder of truths.
        pool: For effects side by side.
    """
    climb = partial(staircase, trials=trials, seed=seed, folder=folder, answer=answer)
    results = dict(zip(effects, pool.map(climb, effects), strict=True))
    rows = [[effect, *half_way(tried), len(tried)] for effect, tried in results.items()]
    show("found half of the time (effect over noise)", ["effect", "strength", "from", "to", "trials"], rows)
    return {row[0]: row[1:4] for row in rows}


def staircase(
    effect: str, trials: int, seed: int, folder: Path, answer: Callable[[Path], Answerer]
) -> list[tuple[float, bool]]:
    """Up and down about the strength that is found half of the time; visibility and whether found."""
    tried, wanted = [], 1.0
    for trial in range(trials):
        name = f"{effect}_{trial}"
        arm = list(ARMS)[trial % len(ARMS)]
        case = Draw(
            name,
            arm,
            "single",
            "",
            (effect,),
            (wanted,),
            seed + 1000 * list(VOCABULARY).index(effect) + trial,
        )
        place = make(case, folder / "cases", folder / "truth")
        truth = read_truth(folder / "truth" / f"{name}.json")
        found = recalled(Pair(truth, read_answer(answer(folder / "truth")(place))))[0]
        shutil.rmtree(place)
        tried.append((truth.visibility[0], found))
        wanted = float(np.clip(wanted / STEP if found else wanted * STEP, *BOUNDS))
    return tried
