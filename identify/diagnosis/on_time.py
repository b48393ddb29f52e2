"""On time: a delay that was found, moved until no clock is left to be wrong.

How well rows fit over a delay tells when current and motion go together, feedback among them: noise of a
motion comes back as current, later. How far clocks have to be wrong beside it tells the delay itself.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .candidate import Thinned
from .found import Found
from .nuisances import CLOCK
from .scene import Scene

TURNS = 2
"""Times that a delay is moved: clocks are linear in it, to a tenth over a millisecond."""


def on_time(scene: Scene, found: Sequence[Found]) -> list[Found]:
    """Findings with the delay of all drives, if there is one, where their clocks are right on the mean."""
    moved = list(found)
    for place, one in enumerate(found):
        if one.hypothesis.candidate.effect == "time_delay" and np.all(one.hypothesis.columns.whole):
            for _ in range(TURNS):
                moved[place] = _later(scene, moved[place], _lateness(scene, moved))
    return moved


def _lateness(scene: Scene, found: Sequence[Found]) -> float:
    """By how much currents still come later than positions, mean of all drives [s]."""
    solution = scene.solution(found)
    by_name = zip(solution.rows.names, solution.values, strict=True)
    clocks = {name: float(value) for name, value in by_name if name.startswith(CLOCK)}
    return clocks.pop(CLOCK) + float(np.mean(list(clocks.values())))


def _later(scene: Scene, one: Found, seconds: float) -> Found:
    hypothesis = one.hypothesis
    assert hypothesis.candidate.reshaped is not None
    candidate = hypothesis.candidate.reshaped({"delay": hypothesis.candidate.shape["delay"] + seconds})
    columns = Thinned.of(candidate, scene.runs)
    return one._replace(hypothesis=replace(hypothesis, candidate=candidate, columns=columns))
