"""Additions: the findings that are credible given all others, added one at a time."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..blocks.block_likelihood import strain
from ..blocks.prediction import LINEAR, Prediction
from ..candidates import dependence_of, kind_of
from ..questions.block_answer import CERTAIN_ODDS, Answer
from ..questions.candidate import Candidate
from ..questions.candidate_fit import FORMULA
from ..questions.comparison import by_blocks, colouring, competing, explained_variance, seeing
from ..questions.question import ask
from .checks import answer_beside
from .once import with_contacts
from .problem import Problem
from .ranking import Shapes, ranked
from .selected import Selected, answers_of, compared_with, credible, keys_of, log_prior
from .simpler import SAME, simplest

TURNS = 16
"""Maximum number of additions in one pass."""


def with_additions(
    problem: Problem, selected: list[Selected], total: float, shapes: Shapes, out: set[object]
) -> tuple[Problem, list[Selected]]:
    """Findings with all credible additions, and the problem at their load.

    Hypotheses on the joints of the latest finding are tested until none is credible, then all hypotheses.

    Hypotheses whose keys are in `out` are not added.
    """
    out, joints = set(out), None
    for _ in range(TURNS):
        problem, selected = with_contacts(problem, selected)
        prediction = problem.prediction(answers_of(selected))
        best = ranked(problem, prediction, selected, shapes, joints)
        open_ = [answer for answer in material_answers(best, prediction) if answer.candidate.key not in out]
        finding = formula_first(prediction, without_idle_curves(open_, prediction), total)
        if finding is None and (joints is None or len(joints) == prediction.joints):
            break
        joints = np.flatnonzero(seeing(finding.answer)) if finding else None
        if finding is None:
            continue
        candidate = finding.answer.candidate
        uncovered = [other for other in selected if not other.answer.candidate.covered([candidate])]
        reloaded, needed = _still_needed(problem, [*uncovered, finding], total)
        gone = keys_of([*selected, finding]) - keys_of(needed)
        if gone and advantage(reloaded, needed, selected, total) <= 0.0:
            out.add(candidate.key)  # it would replace findings that explain more
            continue
        if reloaded is not problem:
            problem.forget()
        problem, selected = reloaded, needed
        out |= gone  # in this pass: they would alternate
    return problem, selected


def formula_first(prediction: Prediction, best: Sequence[Answer], total: float) -> Selected | None:
    """The most probable credible hypothesis; of a curve, first a credible formula over the same quantity.

    A curve over a quantity fits any formula over it, and more. If it is credible beside the formula too, it
    is added later, and the formula goes if it is no longer needed.
    """
    finding = simplest(prediction, best, total)
    place = _dependence(finding.answer.candidate) if finding else None
    if finding is None or place is None or kind_of(finding.answer.candidate.effect).formula:
        return finding
    here = [answer for answer in best if _dependence(answer.candidate) == place]
    formulas = [answer for answer in here if kind_of(answer.candidate.effect).formula]
    chosen = simplest(prediction, formulas, total)
    if chosen is None:
        return finding
    curves = {id(answer) for answer in here} - {id(answer) for answer in formulas}
    others = [answer for answer in best if id(answer) not in curves]
    return compared_with(chosen, others, total, lambda first, second: by_blocks(prediction, first, second))


def material_answers(answers: Sequence[Answer], prediction: Prediction) -> list[Answer]:
    """Answers that make blocks more probable, and whose effect is material."""
    return [answer for answer in answers if answer.gain > 0.0 and _material(answer, prediction)]


def _material(answer: Answer, prediction: Prediction) -> bool:
    """Whether an effect explains more of the residual than errors in the formulas of other effects could.

    This is judged on that of its joints that shows it best, by the common variance of blocks. A torque that
    varies as smoothly as the motion must also exceed the sensors' error of the joint's usual torque.
    """
    acting, torque, usual = answer.columns.joints, answer.torque, answer.columns.usual
    joint = int(acting[np.argmax(answer.by_joint[acting])])
    before, explained = explained_variance(prediction, answer, joint)
    least, varies = FORMULA**2 * before, np.ptp(torque, axis=0).max() > SAME * np.abs(torque).max()
    if answer.candidate.smooth and varies and usual is not None:
        least = max(least, (LINEAR * usual[acting == joint][0]) ** 2)
    return explained > least or answer.relief > CERTAIN_ODDS


def without_idle_curves(best: Sequence[Answer], prediction: Prediction) -> list[Answer]:
    """Answers without the curves that explain hardly more than a formula over the same quantity."""
    explained = {id(answer): explained_variance(prediction, answer, answer.joint)[1] for answer in best}
    formulas: dict[tuple[str, tuple[int, ...]], float] = {}
    for answer in best:
        place = _dependence(answer.candidate)
        if place and kind_of(answer.candidate.effect).formula:
            formulas[place] = max(formulas.get(place, 0.0), explained[id(answer)])

    def needed(answer: Answer) -> bool:
        place = _dependence(answer.candidate)
        if place is None or kind_of(answer.candidate.effect).formula:
            return True
        return explained[id(answer)] > (1.0 + FORMULA**2) * formulas.get(place, 0.0)

    return [answer for answer in best if needed(answer)]


def _dependence(candidate: Candidate) -> tuple[str, tuple[int, ...]] | None:
    """Quantity that the torque of a candidate depends on, and its joints."""
    dependence = dependence_of(candidate)
    return (dependence, candidate.joints) if dependence else None


def _still_needed(problem: Problem, selected: list[Selected], total: float) -> tuple[Problem, list[Selected]]:
    """Findings that are still needed given the last one, and the problem at their load."""
    latest = selected[-1].answer
    if latest.candidate.carried or latest.candidate.reloads:
        problem, selected = at_own_load(problem, selected)
    with_all = problem.prediction(answers_of(selected), problem.prediction(answers_of(selected[:-1])))
    for finding in [old for old in selected[:-1] if not old.once and competing(old.answer, latest)]:
        others = [other for other in selected if other is not finding]
        answer = answer_beside(problem, finding.answer, answers_of(others), with_all)
        answer = answer or _in_allowed_shape(problem, finding.answer, answers_of(others), with_all)
        if answer is None or not credible(answer.odds + log_prior(answer, total), finding):
            selected = others
            continue
        # Given the others, a coefficient may have reached a physical limit, or left it.
        refitted = {name: getattr(answer, name) for name in ("candidate", "columns", "values", "free")}
        bounded = replace(finding.answer, **refitted)
        selected = [other._replace(answer=bounded) if other is finding else other for other in selected]
    return problem, selected


def at_own_load(problem: Problem, selected: Sequence[Selected]) -> tuple[Problem, list[Selected]]:
    """The problem and the findings at the load that follows from these findings."""
    problem, answers = problem.at_load_of(answers_of(selected))
    pairs = zip(selected, answers, strict=True)
    return problem, [finding._replace(answer=answer) for finding, answer in pairs]


def _in_allowed_shape(
    problem: Problem, answer: Answer, others: Sequence[Answer], similar: Prediction
) -> Answer | None:
    """The same effect in its most probable shape that physics allows given the others; None without any."""
    shapes = problem.pairs(lambda candidate, _: candidate.key == answer.candidate.key)
    if len(shapes) < 2:
        return None
    prediction = problem.prediction(others, similar)
    best = max(ask(prediction, shapes), key=lambda shape: shape.gain, default=None)
    return colouring(prediction, best).chosen_as(answer) if best else None


def advantage(problem: Problem, after: Sequence[Selected], before: Sequence[Selected], total: float) -> float:
    """Log odds of one list of findings against another, from fitted blocks, priors and shape costs.

    A finding costs the log odds at which it is credible, so that no list gains by findings that are not.
    """
    new, old = (problem.prediction(answers_of(findings)) for findings in (after, before))
    # Both at the same share of independent rows: the better model leaves the whiter residual.
    independent = np.maximum(new.weighting.independent, old.weighting.independent)
    gain = new.log_probability(new.errors, independent) - old.log_probability(old.errors, independent)
    relief = _strain(old) - _strain(new)
    costs = [sum(_cost(finding, total) for finding in findings) for findings in (after, before)]
    return float(gain[problem.blocks.fitted].sum()) + relief - costs[0] + costs[1]


def _strain(prediction: Prediction) -> float:
    """Loss in log probability of the stated unknowns, which deviate from their priors."""
    rows, known = prediction.rows, prediction.stated
    apart = (prediction.values - rows.mean)[known] / rows.std[known]
    return strain(apart, rows.bounded[known])


def _cost(finding: Selected, total: float) -> float:
    """Loss in log probability that a finding must make up for."""
    return finding.answer.cost - log_prior(finding.answer, total) + CERTAIN_ODDS * (not finding.once)
