"""Search: one effect at a time is added, everything solved anew, until nothing more is credible."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..model import Model
from .candidate import Candidate, Thinned
from .candidates import candidates
from .candidates.contact import Reach, touches
from .driven import Driven
from .hypothesis import WORTH, Hypothesis, refined, reshaped, weigh
from .nuisances import with_nuisances
from .recolouring import recoloured
from .reloading import UNSETTLING, Known, alike, anew
from .rows import Rows, model_rows
from .solution import Solution
from .whitening import Whitening

TURNS = 12
"""Times that something is taken in, at most: what came in may go out again for something better."""
AGAIN = 8
"""Times that unknowns and colour are found in turn, at most."""
SETTLED = 0.1
"""Change of the logarithm of a probability that is not worth another turn."""
MOST = 6
"""Effects that are looked for; an arm with more than that needs another belief, not a diagnosis."""
REFINE = 6
"""Hypotheses whose shape is refined before the best is chosen."""
RECOLOUR, COLOURED, SHARE = 12, 4, 0.2
"""Hypotheses that are weighed beside noise of their own colour, at most and at least; and the share of the
foremost one's evidence below which no other has come first that way."""
ANEW = 3
"""Hypotheses whose shape is refined again, beside noise of that colour."""
PRIOR = 0.5
"""Probability before the data that something is missing."""
CREDIBLE = 0.95
"""Probability from which on something is taken to be there, and below which it is taken out again."""
CERTAIN_ODDS = float(np.log(CREDIBLE / (1 - CREDIBLE)))
"""Logarithm of the odds at that probability."""
FORMULA = 0.25
"""How wrong the formula of an effect may be, share of its torque [-]: friction laws are no better."""
FIRST_ORDER = 0.1
"""Likewise where a link's own motion is followed to first order only, and of any formula on its own joint."""
ENDING = {"drive_gain_saturation", "current_clipping"}
"""Effects of which a drive has one: near its end, either formula leaves what looks like the other."""
HALVES = 0.5
"""Share of a coupled motor's own friction and inertia that may be with one of its joints or the other."""
SWINGING = ("joint_elasticity", "backlash")
"""Effects in which a link moves otherwise than its motor, and all that it carries with it."""
SPLIT = ("viscous_friction", "coulomb_friction", "rotor_inertia")
"""What a motor that turns with two joints splits between them in a way that no formula knows."""
KINDS = (
    {
        "viscous_friction", "coulomb_friction", "friction_asymmetry", "stribeck_friction", "hysteresis",
        "load_dependent_friction", "nonlinear_viscous_friction", "temperature_dependent_friction",
        "position_dependent_friction",
    },
    {"spring_balancer", "joint_spring", "current_offset", "friction_asymmetry"},
    {
        "drive_gain", "drive_gain_saturation", "current_clipping", "time_delay", "joint_elasticity",
        "backlash", "torque_ripple", "hysteresis",
    },
)  # fmt: skip
"""Effects whose formulas stand in for one another: friction, springs, and what drives and gears do."""
BETTER = np.log(20.0)
"""Logarithm of the odds at which a finding gives way to another that explains the same."""

Asked = Sequence[tuple[Candidate, Thinned]]


class Found(NamedTuple):
    """An effect that was found, and what else it might be.

    Attributes:
        hypothesis: The effect.
        others: What may explain the same, the most credible first, with the logarithm of its odds.
        odds: Its own.
    """

    hypothesis: Hypothesis
    others: tuple[tuple[Hypothesis, float], ...]
    odds: float

    @property
    def probability(self) -> float:
        """That it is there, and that it is this and nothing else that explains the same."""
        logs = [0.0, self.odds, *(odds for _, odds in self.others)]
        return float(np.exp(self.odds - np.logaddexp.reduce(logs)))

    @property
    def not_excluded(self) -> list[tuple[Hypothesis, float]]:
        """Others that are credible enough to be told, with their probability."""
        total = np.logaddexp.reduce([0.0, self.odds, *(odds for _, odds in self.others)])
        every = [(one, float(np.exp(odds - total))) for one, odds in self.others]
        return [(one, p) for one, p in every if p > 1 - CREDIBLE]

    def beside(self, best: Sequence[Hypothesis], count: int) -> "Found":
        """Without those others that are as credible beside it as they were instead of it.

        Args:
            best: What there may be beside everything found.
            count: Number of hypotheses.
        """
        too = {one.candidate.key for one in best if odds_of(one, count) > CERTAIN_ODDS}
        return self._replace(others=tuple(pair for pair in self.others if pair[0].candidate.key not in too))


@dataclass(frozen=True, eq=False)
class Scene:
    """What a search looks at.

    Attributes:
        model: As believed.
        runs: Those that may be fitted, with the load that gears transmit as far as it is known.
        rows: Of these runs, with nuisances and without findings.
        asked: All hypotheses that do not depend on what is left.
        reaches: Of a force on the flange, in each run.
        base: Rows with the model's own unknowns alone.
        known: What makes the torque and the load of any run.
    """

    model: Model
    runs: tuple[Driven, ...]
    rows: Rows
    asked: Asked
    reaches: tuple[Reach, ...]
    base: Rows
    known: Known

    @classmethod
    def of(cls, model: Model, runs: Sequence[Driven]) -> "Scene":
        """With the load of a first fit."""
        base = model_rows(model, runs)
        known = Known.after(model, solved(base)).of(runs)
        runs = tuple(known.on(run) for run in runs)
        asked = [(candidate, Thinned.of(candidate, runs)) for candidate in candidates(model)]
        reaches = tuple(Reach.of(model, run) for run in runs)
        return cls(model, runs, with_nuisances(base, model, runs), asked, reaches, base, known)

    @property
    def count(self) -> int:
        """Number of hypotheses; a touch of the arm, which may be any time, is one."""
        return len({candidate.key for candidate, _ in self.asked}) + 1

    @property
    def tried(self) -> dict[str, int]:
        """Effects that these runs can be asked for, with how many hypotheses there are of each."""
        keys = {candidate.key for candidate, columns in self.asked if not columns.empty}
        return dict(Counter(effect for effect, _ in keys)) | {"contact_event": 1}

    def solution(self, found: Sequence[Found]) -> Solution:
        """With the columns of what was found."""
        pairs = [(one.hypothesis, one.hypothesis.columns) for one in found]
        return solved(with_found(self.rows, pairs))

    def ranked(self, found: Sequence[Found]) -> list[Hypothesis]:
        """What else there may be, the most credible first."""
        taken = {one.hypothesis.candidate.key for one in found}
        solution = self.solution(found)
        windows = touches(self.model, solution, self.runs, self.reaches)
        touched = [(one, Thinned.of(one, self.runs)) for one in windows]
        return ranked(
            solution, [one for one in [*self.asked, *touched] if one[0].key not in taken], self.runs
        )

    def bearing(self, found: Sequence[Found]) -> tuple["Scene", list[Found]]:
        """The same, and the findings, with the load that gears transmit beside what was found."""
        unsettled = any(one.hypothesis.candidate.effect in UNSETTLING for one in found)
        if not unsettled and self.known.first:
            return self, list(found)
        hypotheses = [one.hypothesis for one in found]
        known = Known.after(self.model, self.solution(found), hypotheses).of(self.runs)
        runs = tuple(known.on(run) for run in self.runs)
        if alike(self.runs, runs):
            return self, list(found)
        fresh = [
            one._replace(hypothesis=replace(old, columns=anew(old.candidate, old.columns, runs)))
            for one, old in zip(found, hypotheses, strict=True)
        ]
        asked = [(candidate, anew(candidate, columns, runs)) for candidate, columns in self.asked]
        rows = with_nuisances(self.base, self.model, runs)
        return replace(self, runs=runs, rows=rows, asked=asked, known=known), fresh


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
        found = _settled(scene, [*found, one])
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


def told_apart(found: Sequence[Found]) -> list[Found]:
    """Findings in the order of their evidence, without what is but the error of another's formula.

    No friction is quite as its formula has it. What that leaves looks like a further, smaller effect of the
    same joint.
    """
    kept: list[Found] = []
    for one in sorted(found, key=lambda one: -one.hypothesis.evidence):
        own, greater = one.hypothesis, [other.hypothesis for other in kept]
        if all(own.evidence > _error(own, other) * other.evidence for other in greater):
            kept.append(one)
    return kept


def _error(one: Hypothesis, other: Hypothesis) -> float:
    """Share of the other's evidence that one may have by being the error of the other's formula."""
    own, more = one.candidate, other.candidate
    if own.joints == more.joints and {own.effect, more.effect} == ENDING:
        return 1.0
    if own.joints == more.joints and any({own.effect, more.effect} <= kind for kind in KINDS):
        return FORMULA**2
    if more.effect == "kinematic_coupling" and own.effect in SPLIT and set(own.joints) < set(more.joints):
        return HALVES**2
    if own.joints and own.joints == more.joints:
        return FIRST_ORDER**2
    return FIRST_ORDER**2 if more.effect in SWINGING and competing(one, other) else 0.0


def solved(rows: Rows) -> Solution:
    """Solution of rows whose residual is white; its colour is found on the way."""
    solution = Solution(rows, Whitening.of(rows.difference, rows.weight, rows.runs, order=0))
    coloured = Solution(rows, Whitening.of(solution.residual, rows.weight, rows.runs))
    for _ in range(AGAIN):
        again = Solution(rows, Whitening.of(coloured.residual, rows.weight, rows.runs))
        if again.probability < coloured.probability + SETTLED:
            break
        coloured = again
    return coloured


def ranked(solution: Solution, every: Asked, runs: Sequence[Driven]) -> list[Hypothesis]:
    """Hypotheses by evidence: the shapes of the foremost refined, each beside noise of its own colour."""
    weighed = weigh(solution, every)
    chosen = [
        place
        for place, one in enumerate(weighed[:RECOLOUR])
        if place < COLOURED or one.own > SHARE * weighed[0].own
    ]
    first = [
        refined(solution, weighed[place], runs)
        if place < REFINE and _near(weighed[place], weighed[0])
        else weighed[place]
        for place in chosen
    ]
    found = [recoloured(solution, one) for one in first]
    found.sort(key=lambda pair: -pair[0].evidence)
    for place, (one, whitening) in enumerate(found[:ANEW]):
        if one.candidate.bounds and _near(one, found[0][0]):
            colour = replace(solution, whitening=whitening)
            found[place] = recoloured(solution, reshaped(colour, one, runs))
    best = [one for one, _ in found] + [one for k, one in enumerate(weighed) if k not in chosen]
    return sorted(best, key=lambda one: -one.evidence)


def _near(one: Hypothesis, best: Hypothesis) -> bool:
    """Whether another shape between those that were tried may make it credible, and the best."""
    return one.own > max(WORTH, 0.5 * best.own)


def odds_of(hypothesis: Hypothesis, count: int) -> float:
    """Logarithm of the odds of a hypothesis against nothing more.

    Every one of `count` hypotheses is as likely as the others before the data, and together they are as
    likely as nothing.
    """
    return float(hypothesis.evidence + np.log(PRIOR / (1 - PRIOR) / count))


def judged(best: Sequence[Hypothesis], count: int) -> Found | None:
    """The foremost hypothesis, if it is credible that anything is there at all."""
    if not best:
        return None
    odds = [odds_of(one, count) for one in best]
    if np.logaddexp.reduce(odds) < CERTAIN_ODDS:
        return None
    others = [
        pair for pair in zip(best[1:], odds[1:], strict=True) if competing(pair[0], best[0]) and pair[1] > -20
    ]
    return Found(best[0], tuple(others), odds[0])


def competing(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether both give torque to one joint, and so may explain the same."""
    return bool(np.intersect1d(one.columns.joints, other.columns.joints).size)


def with_found(rows: Rows, found: Sequence[tuple[Hypothesis, Thinned]]) -> Rows:
    """Rows with columns of hypotheses, their coefficients believed as when they were weighed."""
    for one, columns in found:
        names = [f"{one.candidate.effect} {name}" for name in one.candidate.names]
        rows = rows.plus(names, columns.everywhere(rows.difference.shape[1]), one.found_std)
    return rows
