"""Search: effects are added, and each is chosen anew given all others, until a pass changes nothing."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..blocks.prediction import LINEAR, Prediction
from ..candidates import KINDS, family_of, kind_of
from ..findings.family import FAMILIES
from ..questions.block_answer import CERTAIN_ODDS, Answer
from ..questions.candidate import Candidate, Thinned
from ..questions.candidate_fit import FORMULA
from ..questions.comparison import colouring, competing, seeing
from ..questions.question import ask
from ..questions.shape import refined
from .checks import again_beside, in_shape, judged_by_held_out, nominal_where_better
from .held_out import proven
from .once import only_once
from .problem import Problem
from .ranking import Shapes, ranked, total_prior
from .selected import Selected, answers_of, credible, keys_of, log_prior, odds_of
from .simpler import simplest

TURNS = 16
"""Times that something is added in one pass, at most."""
PASSES = 4
"""Passes, at most: most searches are at rest after two or three; in some, findings come and go to the end."""


@dataclass(frozen=True, eq=False)
class SearchResult:
    """What a search has come to."""

    problem: Problem  # the runs, and what was asked
    selected: tuple[Selected, ...]  # in the order of their columns, the greatest first
    prediction: Prediction  # with columns for everything that was found, at the end of its rows
    without_findings: Prediction  # prediction without any of them
    single: tuple[Answer, ...]  # all hypotheses, each beside nothing else, the most probable first
    left: tuple[Answer, ...] = ()  # the others beside all findings, the most probable first
    total: float = 1.0  # sum of the prior weights of all hypotheses

    def ordered(self) -> "SearchResult":
        """The same with those findings first that are certain enough to be named."""
        selected = sorted(self.selected, key=lambda one: not one.named)
        return replace(
            self, selected=tuple(selected), prediction=self.problem.prediction(answers_of(selected))
        )


def search(problem: Problem) -> SearchResult:
    """Find what the model leaves out."""
    without_findings = problem.without_findings
    selected = _measured(problem, without_findings)
    problem = problem.asking(_asked_first(problem, without_findings))
    shapes: Shapes = {}
    every = ranked(problem, without_findings, [], shapes)
    total, single = total_prior(every, problem), without_idle_curves(every, without_findings)
    before, visited = list[Selected](), list[set[object]]()
    for _ in range(PASSES):
        at, added = _added(problem, selected, total, shapes)
        problem, added = _bearing(at, added)
        if problem is not at:
            at.forget()
        changed = _changed(before, added, without_findings.joints) | (problem is not at)
        before = selected = _chosen_anew(problem, added, total, changed, shapes)
        keys = keys_of(selected)
        if (problem is at and keys == keys_of(added)) or keys in visited:  # at rest, or some come and go
            break
        visited.append(keys)
    kept = judged_by_held_out(problem, selected, without_findings, total)
    problem = nominal_where_better(problem, kept, without_findings)
    kept = proven(problem, kept)
    prediction = problem.prediction(answers_of(kept))
    return SearchResult(
        problem,
        tuple(kept),
        prediction,
        without_findings,
        tuple(single),
        tuple(ranked(problem, prediction, kept, shapes)),
        total,
    )


def _asked_first(problem: Problem, prediction: Prediction) -> Iterator[Candidate]:
    """Hypotheses by what the model leaves without any finding."""
    for kind in KINDS.values():
        if kind.ask_first is not None:
            yield from kind.ask_first(problem.model, prediction, problem.runs)


def _measured(problem: Problem, prediction: Prediction) -> list[Selected]:
    """Effects that were measured otherwise than by torque, the most certain first.

    Where blocks show the torque of one as well, that is taken.
    """
    found = []
    for measured in (kind.measured for kind in KINDS.values() if kind.measured):
        for evidence, answer in measured(problem.model, prediction, problem.runs):
            odds = odds_of(evidence, prediction.joints)
            if odds > CERTAIN_ODDS:
                found.append(Selected(answer, odds, (), once=True))
    found.sort(key=lambda one: -one.odds)
    for place, one in enumerate(found):
        before = problem.prediction(answers_of(found[:place]))
        found[place] = _with_torque(problem, before, one.answer.candidate) or one
    return found


def _with_torque(problem: Problem, prediction: Prediction, measured: Candidate) -> Selected | None:
    """What was measured otherwise, with its torque; None where blocks do not show that."""
    candidate = measured.reshaped(measured.shape)
    for answer in ask(prediction, [(candidate, Thinned.of(candidate, problem.runs))]):
        best = refined(prediction, answer, problem.runs)
        odds = odds_of(best, prediction.joints)
        if odds > CERTAIN_ODDS:
            return Selected(best, odds)
    return None


def _added(
    problem: Problem, selected: list[Selected], total: float, shapes: Shapes
) -> tuple[Problem, list[Selected]]:
    """Findings with all that is credible beside them, and the problem at their load.

    Hypotheses that the latest finding's joints see are asked until none is credible, then all are.
    """
    out: set[object] = set()
    joints: np.ndarray | None = None
    for _ in range(TURNS):
        problem, selected = only_once(problem, selected)
        prediction = problem.prediction(answers_of(selected))
        best = ranked(problem, prediction, selected, shapes, joints)
        open_ = [one for one in _material_answers(best, prediction) if one.candidate.key not in out]
        one = simplest(prediction, without_idle_curves(open_, prediction), total)
        if one is None and (joints is None or len(joints) == prediction.joints):
            break
        joints = np.flatnonzero(seeing(one.answer)) if one else None
        if one is None:
            continue
        beside = [other for other in selected if not other.answer.candidate.covered([one.answer.candidate])]
        settled, stay = _settled(problem, [*beside, one], total)
        gone = keys_of([*selected, one]) - keys_of(stay)
        if gone and _less_probable(settled, stay, selected):
            out.add(one.answer.candidate.key)  # it takes out what explains more
            continue
        if settled is not problem:
            problem.forget()
        problem, selected = settled, stay
        out |= gone  # in this pass: it would come and go
    return problem, selected


def _chosen_anew(
    problem: Problem, selected: list[Selected], total: float, changed: np.ndarray, shapes: Shapes
) -> list[Selected]:
    """Each finding replaced by the most probable hypothesis beside all others; one not credible goes.

    Those on whose joints nothing has changed since they were chosen stay.
    """
    whole = problem.prediction(answers_of(selected))
    for one in list(selected):
        settled = not np.any(seeing(one.answer) & changed)
        if settled or one.once or not (one.others or one.answer.candidate.bounds):
            continue
        place, others = selected.index(one), [other for other in selected if other is not one]
        prediction = problem.prediction(answers_of(others), whole)
        again = in_shape(problem, prediction, one.answer)
        shapes[again.candidate.key] = again
        best = ranked(problem, prediction, others, shapes, np.flatnonzero(seeing(again)))
        best = without_idle_curves(_material_answers(best, prediction), prediction)
        chosen = simplest(prediction, best, total)
        selected = [*selected[:place], *([chosen] if chosen else []), *selected[place + 1 :]]
    return selected


def _changed(before: Sequence[Selected], after: Sequence[Selected], joints: int) -> np.ndarray:
    """Joints that see what only one of two lists of findings has, shape (n,)."""
    apart = keys_of(before) ^ keys_of(after)
    changed = np.zeros(joints, bool)
    for one in (*before, *after):
        if one.answer.candidate.key in apart:
            changed |= seeing(one.answer)
    return changed


def _less_probable(problem: Problem, some: Sequence[Selected], others: Sequence[Selected]) -> bool:
    """Whether blocks are less probable with some findings than with others."""
    one, other = (problem.prediction(answers_of(found)) for found in (some, others))
    independent = other.weighting.independent
    gain = one.log_probability(one.errors, independent) - other.log_probability(other.errors, independent)
    return float(gain.sum()) < 0.0


def _material_answers(answers: Sequence[Answer], prediction: Prediction) -> list[Answer]:
    """The answers that make blocks more probable, and whose effect is material."""
    return [answer for answer in answers if answer.gain > 0.0 and _material(answer, prediction)]


def _material(one: Answer, prediction: Prediction) -> bool:
    """Whether an effect explains more of what is left than the formulas of others may be wrong by.

    On the joint that shows it best, by the variance that blocks share. A smooth torque must also be more than
    the sensors' error of the joint's usual torque.
    """
    joint = int(np.argmax(one.by_joint))
    variance = prediction.common_variance(np.stack([one.predicted, one.errors]), one.independent)
    before, after = variance[:, joint]
    least, usual = FORMULA**2 * before, one.columns.usual
    if one.candidate.smooth and usual is not None and joint in one.columns.joints:
        least = max(least, (LINEAR * usual[one.columns.joints == joint][0]) ** 2)
    return bool(before - after > least) or one.relief > CERTAIN_ODDS


def without_idle_curves(best: Sequence[Answer], prediction: Prediction) -> list[Answer]:
    """The answers without curves that explain hardly more than a formula of the same dependence."""
    explained = {id(one): _explained(one, prediction) for one in best}
    formulas: dict[tuple[str, tuple[int, ...]], float] = {}
    for one in best:
        place = _dependence(one.candidate)
        if place and kind_of(one.candidate.effect).formula:
            formulas[place] = max(formulas.get(place, 0.0), explained[id(one)])

    def needed(one: Answer) -> bool:
        place = _dependence(one.candidate)
        if place is None or kind_of(one.candidate.effect).formula:
            return True
        return explained[id(one)] > (1.0 + FORMULA**2) * formulas.get(place, 0.0)

    return [one for one in best if needed(one)]


def _dependence(candidate: Candidate) -> tuple[str, tuple[int, ...]] | None:
    """What the torque of a candidate depends on, and its joints."""
    family = family_of(candidate)
    return (FAMILIES[family].dependence, candidate.joints) if family else None


def _explained(one: Answer, prediction: Prediction) -> float:
    """Variance that an effect takes from the joint that shows it best [(N m)^2]."""
    variance = prediction.common_variance(np.stack([one.predicted, one.errors]), one.independent)
    before, after = variance[:, int(np.argmax(one.by_joint))]
    return float(before - after)


def _settled(problem: Problem, selected: list[Selected], total: float) -> tuple[Problem, list[Selected]]:
    """Findings that are each still needed beside the one that came last, at the load they leave."""
    latest = selected[-1].answer
    if latest.candidate.carried or latest.candidate.reloads:
        problem, selected = _bearing(problem, selected)
    whole = problem.prediction(answers_of(selected), problem.prediction(answers_of(selected[:-1])))
    for one in [one for one in selected[:-1] if not one.once and competing(one.answer, latest)]:
        others = [other for other in selected if other is not one]
        again = again_beside(problem, one.answer, answers_of(others), whole)
        again = again or _in_allowed_shape(problem, one.answer, answers_of(others), whole)
        if again is None or not credible(again.odds + log_prior(again, total), one):
            selected = others
            continue
        # Beside others a coefficient may have come to a limit of physics, or left it.
        own = {name: getattr(again, name) for name in ("candidate", "columns", "values", "free")}
        bounded = replace(one.answer, **own)
        selected = [other._replace(answer=bounded) if other is one else other for other in selected]
    return problem, selected


def _bearing(problem: Problem, selected: Sequence[Selected]) -> tuple[Problem, list[Selected]]:
    """The problem and the findings at the load that they leave."""
    problem, answers = problem.bearing(answers_of(selected))
    return problem, [one._replace(answer=answer) for one, answer in zip(selected, answers, strict=True)]


def _in_allowed_shape(
    problem: Problem, answer: Answer, others: Sequence[Answer], near: Prediction
) -> Answer | None:
    """The same effect in its most probable shape that physics allows beside some others, if any."""
    shapes = problem.pairs(lambda candidate, _: candidate.key == answer.candidate.key)
    if len(shapes) < 2:
        return None
    prediction = problem.prediction(others, near)
    again = max(ask(prediction, shapes), key=lambda one: one.gain, default=None)
    return colouring(prediction, again).chosen_as(answer) if again else None
