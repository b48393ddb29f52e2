"""Search: one effect at a time is added, everything solved anew, until nothing more is credible."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..blocks.prediction import Prediction
from ..candidates import kinds
from ..questions.block_answer import Answer
from ..questions.candidate import Thinned
from ..questions.candidate_fit import FORMULA
from ..questions.comparison import colouring, levelled
from ..questions.question import ask
from ..questions.shape import refined
from .found import CERTAIN_ODDS, Found, judged, log_prior
from .link_encoders import measured_gears
from .mounting import mounted_otherwise
from .once import only_once
from .scene import Scene

TURNS = 16
"""Times that something is added, at most: what came in may go out again for something better."""
COLOURED = 14
"""Hypotheses whose answers are weighed with the colour of what they leave."""
REFINE = 3
"""Hypotheses whose shape is refined before the best is chosen."""
MATERIAL = FORMULA**2
"""Share of what the nominal model misses on a joint that an effect explains there at least [-]: as much as
the formula of the greatest effect may leave."""
WORSE = 1.02
"""Residual of a joint held out, over that without any finding, which is no harm yet: noise does that [-]."""
NEAR = 0.5
"""Share of the foremost gain below which no finer shape makes a hypothesis the foremost [-]."""


@dataclass(frozen=True, eq=False)
class Searched:
    """What a search has come to.

    Attributes:
        scene: The runs, and what was asked.
        found: In the order of their columns, the greatest first.
        prediction: With columns for everything that was found, at the end of its rows.
        believed: Prediction without any of them.
        single: Answers of all hypotheses, each beside nothing else, the most probable first.
    """

    scene: Scene
    found: tuple[Found, ...]
    prediction: Prediction
    believed: Prediction
    single: tuple[Answer, ...]

    def ordered(self) -> "Searched":
        """The same with those findings first that are certain enough to be named."""
        found = sorted(self.found, key=lambda one: not one.named)
        return replace(self, found=tuple(found), prediction=self.scene.prediction(_answers(found)))


def search(scene: Scene) -> Searched:
    """Find what the model leaves out."""
    found = list(measured_gears(scene))
    scene = replace(scene, asked=[*scene.asked, *mounted_otherwise(scene)])
    believed, single = scene.prediction([]), list[Answer]()
    out: set[object] = set()
    total = 1.0
    for _ in range(TURNS):
        scene, found = only_once(scene, found)
        best = ranked(scene, found)
        single, total = single or best, total_prior(best, scene)
        open_ = [one for one in best if one.candidate.key not in out and _material(one, believed)]
        one = judged(open_, total)
        if one is None:
            break
        settled, stay = _settled(scene, [*found, one])
        gone = _keys([*found, one]) - _keys(stay)
        if gone and _less_probable(settled, stay, found):
            out.add(one.answer.candidate.key)  # it takes out what explains more
            continue
        scene, found = settled, stay
        # What went out once is not asked for again: it would come and go.
        out |= gone
    found = _never_worse(scene, _beside_all(scene, found, total), believed)
    scene = _nominal_where_better(scene, found, believed)
    return Searched(scene, tuple(found), scene.prediction(_answers(found)), believed, tuple(single))


def _keys(found: Sequence[Found]) -> set[object]:
    return {one.answer.candidate.key for one in found}


def _less_probable(scene: Scene, some: Sequence[Found], others: Sequence[Found]) -> bool:
    """Whether blocks are less probable with some findings than with others."""
    one, other = (scene.prediction(_answers(found)) for found in (some, others))
    independent = other.weighting.independent
    gain = one.log_probability(one.errors, independent) - other.log_probability(other.errors, independent)
    return float(gain.sum()) < 0.0


def _material(one: Answer, believed: Prediction) -> bool:
    """Whether an effect matters beside what the nominal model misses on the joint that shows it best."""
    joint = int(np.argmax(one.by_joint))
    less = float((one.predicted - one.errors)[:, joint].sum())
    return less > MATERIAL * float(believed.errors[:, joint].sum()) or one.relief > CERTAIN_ODDS


def _never_worse(scene: Scene, found: list[Found], believed: Prediction) -> list[Found]:
    """Findings with which no joint of the runs held out is predicted worse than without any.

    One goes if the joint that is predicted worst gains by that, and more than any other loses where it has a
    name; the least credible first. What none of them is to blame for stays as it is.
    """
    while np.max(now := _held_out(scene, found, believed), initial=0.0) > WORSE**2:
        going, kept = None, found
        for one in sorted((one for one in found if not one.once), key=lambda one: one.certainty):
            others = [other for other in found if other is not one]
            without = _held_out(scene, others, believed)
            gained = float(np.max(now) / np.max(without))
            lost = float(np.max(without / now)) if one.named else 1.0
            if gained > max(WORSE, lost) and (going is None or gained > going * WORSE):
                going, kept = gained, others
        if going is None:
            break
        found = kept
    return found


def _nominal_where_better(scene: Scene, found: Sequence[Found], believed: Prediction) -> Scene:
    """The scene with the nominal values of parameters, where those fitted predict a joint held out worse."""
    worst = np.max(_held_out(scene, found, believed), initial=0.0)
    nominal = scene.at_nominal()
    if not found or worst <= WORSE**2 or np.max(_held_out(nominal, found, believed)) >= worst:
        return scene
    return nominal


def _held_out(scene: Scene, found: Sequence[Found], believed: Prediction) -> np.ndarray:
    """Squared residuals of runs held out with findings, over those without any, shape (n,); else empty."""
    which = ~scene.blocks.fitted
    if not np.any(which):
        return np.zeros(0)
    word = believed.sums.errors(np.tile(scene.at_its_word(believed), (len(which), 1)))
    least = np.minimum(believed.power(believed.errors, which), believed.power(word, which))
    now = scene.prediction(_answers(found))
    return now.power(now.errors, which) / least


def _beside_all(scene: Scene, found: list[Found], total: float) -> list[Found]:
    """Findings each in its best shape, and compared anew with what else it may be, beside all others."""
    whole = scene.prediction(_answers(found))
    for place, one in enumerate(found):
        if one.once or not (one.others or one.answer.candidate.bounds):
            continue
        others = [other for other in found if other is not one]
        prediction = scene.prediction(_answers(others), whole)
        first = _in_shape(scene, prediction, one.answer)
        keys = {other.answer.candidate.key for other in others}
        rivals = [answer for answer, _ in one.not_excluded if answer.candidate.key not in keys]
        chosen = {rival.candidate.key: rival for rival in (first, *rivals)}
        asked = [(rival.candidate, rival.columns) for rival in (first, *rivals)]
        again = [one.chosen_as(chosen[one.candidate.key]) for one in ask(prediction, asked)]
        again = sorted(levelled(prediction, again), key=lambda answer: -answer.gain)
        found = [*found[:place], judged(again, total) or one, *found[place + 1 :]]
    return found


def _in_shape(scene: Scene, prediction: Prediction, answer: Answer) -> Answer:
    """The answer refined in shape beside everything else; it was chosen at the cost that it has."""
    if not answer.candidate.bounds:
        return answer
    again = ask(prediction, [(answer.candidate, answer.columns)])
    if not again:
        return answer
    return refined(prediction, again[0].chosen_as(answer), scene.runs).chosen_as(answer)


def total_prior(best: Sequence[Answer], scene: Scene) -> float:
    """Sum of the prior weights of all hypotheses."""
    by_key = {candidate.key: candidate.prior for candidate, _ in scene.asked}
    return float(sum((by_key | {one.candidate.key: one.candidate.prior for one in best}).values()))


def ranked(scene: Scene, found: Sequence[Found]) -> list[Answer]:
    """One answer for each hypothesis beside what was found, the most probable first."""
    taken = {one.answer.candidate.key for one in found}
    prediction = scene.prediction(_answers(found))
    asked = [pair for pair in scene.asked if pair[0].key not in taken]
    for kind in kinds().values():
        rest = kind.ask_of_rest(scene.model, prediction, scene.runs) if kind.ask_of_rest else ()
        asked += [(one, Thinned.of(one, scene.runs)) for one in rest if one.key not in taken]
    best = _by_hypothesis(ask(prediction, asked))
    foremost = levelled(prediction, best[:COLOURED])
    foremost.sort(key=lambda one: -one.gain)
    for place, one in enumerate(foremost[:REFINE]):
        if one.candidate.bounds and one.gain > NEAR * foremost[0].gain > 0.0:
            grid = [pair for pair in asked if pair[0].key == one.candidate.key]
            foremost[place] = refined(prediction, one, scene.runs, grid if one.candidate.among == 1 else ())
    return sorted([*foremost, *best[COLOURED:]], key=lambda one: -one.gain)


def _by_hypothesis(answers: Sequence[Answer]) -> list[Answer]:
    """The best shape of each, at the cost of having chosen it, the most probable first."""
    groups: dict[object, list[Answer]] = {}
    for one in answers:
        groups.setdefault(one.candidate.key, []).append(one)
    found = []
    for group in groups.values():
        best = max(group, key=lambda one: one.gain)
        gain, odds = (float(np.logaddexp.reduce(own) - np.log(len(group))) for own in _measures(group))
        choice = best.choice + max(best.odds - odds, 0.0)
        found.append(replace(best, cost=best.cost + best.gain - gain, choice=choice))
    return sorted(found, key=lambda one: -one.gain)


def _measures(group: Sequence[Answer]) -> tuple[list[float], list[float]]:
    return [one.gain for one in group], [one.odds for one in group]


def _answers(found: Sequence[Found]) -> list[Answer]:
    return [one.answer for one in found]


def _settled(scene: Scene, found: list[Found]) -> tuple[Scene, list[Found]]:
    """Findings that are each still needed beside the one that came last, at the load they leave."""
    scene, answers = scene.bearing(_answers(found))
    found = [one._replace(answer=answer) for one, answer in zip(found, answers, strict=True)]
    whole = scene.prediction(_answers(found))
    for one in [one for one in found[:-1] if not one.once]:
        others = [other for other in found if other is not one]
        again = again_beside(scene, one.answer, _answers(others), whole)
        if again is None or again.gain + log_prior(again, len(scene.tried)) < CERTAIN_ODDS:
            found = others
            continue
        # Beside others a coefficient may have come to a limit of physics, or left it.
        bounded = replace(one.answer, values=again.values, free=again.free)
        found = [other._replace(answer=bounded) if other is one else other for other in found]
    return scene, found


def again_beside(scene: Scene, answer: Answer, others: Sequence[Answer], near: Prediction) -> Answer | None:
    """The answer of the same candidate beside some others; None where physics excludes it there."""
    prediction = scene.prediction(others, near)
    again = ask(prediction, [(answer.candidate, answer.columns)])
    return colouring(prediction, again[0]).chosen_as(answer) if again else None
