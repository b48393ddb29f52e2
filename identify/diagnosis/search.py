"""Search: one effect at a time is added, everything solved anew, until nothing more is credible."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..model import Model
from .driven import Driven
from .formulas import told_apart
from .found import Found, competing, judged
from .hypothesis import Hypothesis
from .on_time import on_time
from .rows import Rows
from .scene import Scene
from .solution import Solution

TURNS = 12
"""Times that something is taken in, at most: what came in may go out again for something better."""
MOST = 6
"""Effects that are looked for; an arm with more than that needs another belief, not a diagnosis."""
BETTER = np.log(20.0)
"""Logarithm of the odds at which a finding gives way to another that explains the same."""


@dataclass(frozen=True, eq=False)
class Searched:
    """What a search has come to.

    Attributes:
        scene: The runs that were fitted, and what was asked.
        solution: With columns for everything that was found, at the end of its rows.
        found: In the order of their columns, the greatest first.
        believed: Solution without any of them.
        next: The best of what was not credible any more.
    """

    scene: Scene
    solution: Solution
    found: tuple[Found, ...]
    believed: Solution
    next: tuple[Hypothesis, ...]

    @property
    def runs(self) -> tuple[Driven, ...]:
        """Those that were fitted."""
        return self.scene.runs

    @property
    def rows(self) -> Rows:
        """With columns for everything that was found."""
        return self.solution.rows

    def keeping(self, places: Sequence[int]) -> "Searched":
        """With some of the findings only."""
        scene, found = self.scene.bearing([self.found[place] for place in places])
        return replace(self, scene=scene, solution=scene.solution(found), found=tuple(found))


def search(model: Model, runs: Sequence[Driven]) -> Searched:
    """Find what the model leaves out.

    Args:
        model: As believed, with its tolerances and with the payloads of the runs.
        runs: Those that may be fitted.
    """
    scene, found = Scene.of(model, runs), list[Found]()
    for _ in range(TURNS):
        best = scene.ranked(found)
        found = [one.beside(best, scene.count) for one in found]
        one = judged(best, scene.count)
        if one is None or len(found) == MOST:
            break
        found = on_time(scene, _settled(scene, [*found, one]))
        scene, found = scene.bearing(found)
    scene, found = scene.bearing(told_apart(found))
    final = scene.solution(found)
    return Searched(scene, final, tuple(found), scene.solution([]), tuple(best[:3]))


def _settled(scene: Scene, found: list[Found]) -> list[Found]:
    """Findings that are each still the best, and still needed, beside the one that came last."""
    for one in found[:-1]:
        if not competing(one.hypothesis, found[-1].hypothesis):
            continue
        others = [other for other in found if other is not one]
        best = [h for h in scene.ranked(others) if competing(h, one.hypothesis)]
        again = judged(best, scene.count)
        if again is None:
            found = others
            continue
        own = [h for h in best if h.candidate.key == one.hypothesis.candidate.key]
        if own and best[0].evidence - own[0].evidence < BETTER:
            again = judged([own[0], *(h for h in best if h is not own[0])], scene.count) or again
        found = [again if other is one else other for other in found]
    return found
