"""Search: effects are added, then each is chosen again given all others, until a pass changes nothing."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..blocks.prediction import LINEAR, Prediction
from ..candidates import KINDS, dependence_of, kind_of
from ..questions.block_answer import CERTAIN_ODDS, Answer
from ..questions.candidate import Candidate, Thinned
from ..questions.candidate_fit import FORMULA
from ..questions.comparison import by_blocks, colouring, competing, explained_variance, seeing
from ..questions.question import ask
from ..questions.shape import refined
from .checks import answer_beside, checked_by_held_out, nominal_if_better, with_refined_shape
from .held_out import proven
from .once import with_contacts
from .problem import Problem
from .ranking import Shapes, ranked, total_prior
from .selected import Selected, answers_of, compared_with, credible, keys_of, log_prior, odds_of
from .simpler import simplest

TURNS = 16
"""Maximum number of additions in one pass."""
PASSES = 4
"""Maximum number of passes: most searches converge in two or three; in some, findings keep alternating."""


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of a search."""

    problem: Problem  # runs and candidates
    selected: tuple[Selected, ...]  # findings in the order of their columns, largest first
    prediction: Prediction  # prediction with the columns of all findings, which are the last of its rows
    without_findings: Prediction  # prediction of the baseline
    single: tuple[Answer, ...]  # every hypothesis as the only finding, most probable first
    left: tuple[Answer, ...] = ()  # remaining hypotheses given all findings, most probable first
    total: float = 1.0  # sum of the prior weights of all hypotheses

    def ordered(self) -> "SearchResult":
        """The same result, with the findings that are certain enough to be named first."""
        selected = sorted(self.selected, key=lambda finding: not finding.named)
        return replace(
            self, selected=tuple(selected), prediction=self.problem.prediction(answers_of(selected))
        )


def search(problem: Problem) -> SearchResult:
    """Find the effects that the model lacks."""
    without_findings = problem.without_findings
    selected = _measured_effects(problem, without_findings)
    problem = problem.with_candidates(_suggested_by_baseline(problem, without_findings))
    shapes: Shapes = {}
    ranking = ranked(problem, without_findings, [], shapes)
    total, single = total_prior(ranking, problem), without_idle_curves(ranking, without_findings)
    before, visited = list[Selected](), list[set[object]]()
    for _ in range(PASSES):
        searched, added = _with_additions(problem, selected, total, shapes)
        problem, added = _at_own_load(searched, added)
        if problem is not searched:
            searched.forget()
        changed = _changed_joints(before, added, without_findings.joints) | (problem is not searched)
        before = selected = _rechosen(problem, added, total, changed, shapes)
        keys = keys_of(selected)
        if (problem is searched and keys == keys_of(added)) or keys in visited:  # converged, or alternating
            break
        visited.append(keys)
    checked = checked_by_held_out(problem, selected, without_findings, total)
    problem = nominal_if_better(problem, checked, without_findings)
    checked = proven(problem, checked)
    prediction = problem.prediction(answers_of(checked))
    return SearchResult(
        problem,
        tuple(checked),
        prediction,
        without_findings,
        tuple(single),
        tuple(ranked(problem, prediction, checked, shapes)),
        total,
    )


def _suggested_by_baseline(problem: Problem, prediction: Prediction) -> Iterator[Candidate]:
    """Candidates that the residual of the baseline suggests."""
    for kind in KINDS.values():
        if kind.ask_first is not None:
            yield from kind.ask_first(problem.model, prediction, problem.runs)


def _measured_effects(problem: Problem, prediction: Prediction) -> list[Selected]:
    """Effects that were measured by other sensors than torque, most certain first.

    If the blocks show the torque of such an effect as well, its answer by torque replaces it.
    """
    findings = []
    for measured in (kind.measured for kind in KINDS.values() if kind.measured):
        for evidence, answer in measured(problem.model, prediction, problem.runs):
            odds = odds_of(evidence, prediction.joints)
            if odds > CERTAIN_ODDS:
                findings.append(Selected(answer, odds, (), once=True))
    findings.sort(key=lambda finding: -finding.odds)
    for place, finding in enumerate(findings):
        before = problem.prediction(answers_of(findings[:place]))
        findings[place] = _with_torque(problem, before, finding.answer.candidate) or finding
    return findings


def _with_torque(problem: Problem, prediction: Prediction, measured: Candidate) -> Selected | None:
    """An effect that another sensor measured, by its torque; None if the blocks do not show that."""
    candidate = measured.reshaped(measured.shape)
    for answer in ask(prediction, [(candidate, Thinned.of(candidate, problem.runs))]):
        best = refined(prediction, answer, problem.runs)
        odds = odds_of(best, prediction.joints)
        if odds > CERTAIN_ODDS:
            return Selected(best, odds)
    return None


def _with_additions(
    problem: Problem, selected: list[Selected], total: float, shapes: Shapes
) -> tuple[Problem, list[Selected]]:
    """Findings with all credible additions, and the problem at their load.

    Hypotheses on the joints of the latest finding are tested until none is credible, then all hypotheses.
    """
    out: set[object] = set()
    joints: np.ndarray | None = None
    for _ in range(TURNS):
        problem, selected = with_contacts(problem, selected)
        prediction = problem.prediction(answers_of(selected))
        best = ranked(problem, prediction, selected, shapes, joints)
        open_ = [answer for answer in _material_answers(best, prediction) if answer.candidate.key not in out]
        finding = _formula_first(prediction, without_idle_curves(open_, prediction), total)
        if finding is None and (joints is None or len(joints) == prediction.joints):
            break
        joints = np.flatnonzero(seeing(finding.answer)) if finding else None
        if finding is None:
            continue
        candidate = finding.answer.candidate
        uncovered = [other for other in selected if not other.answer.candidate.covered([candidate])]
        reloaded, needed = _still_needed(problem, [*uncovered, finding], total)
        gone = keys_of([*selected, finding]) - keys_of(needed)
        if gone and _less_probable(reloaded, needed, selected):
            out.add(candidate.key)  # it would replace findings that explain more
            continue
        if reloaded is not problem:
            problem.forget()
        problem, selected = reloaded, needed
        out |= gone  # in this pass: they would alternate
    return problem, selected


def _formula_first(prediction: Prediction, best: Sequence[Answer], total: float) -> Selected | None:
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


def _rechosen(
    problem: Problem, selected: list[Selected], total: float, changed: np.ndarray, shapes: Shapes
) -> list[Selected]:
    """Each finding replaced by the most probable hypothesis given all others; removed if none is credible.

    Findings on whose joints nothing has changed since they were chosen stay.
    """
    with_all = problem.prediction(answers_of(selected))
    for finding in list(selected):
        unchanged = not np.any(seeing(finding.answer) & changed)
        if unchanged or finding.once or not (finding.others or finding.answer.candidate.bounds):
            continue
        place, others = selected.index(finding), [other for other in selected if other is not finding]
        prediction = problem.prediction(answers_of(others), with_all)
        answer = with_refined_shape(problem, prediction, finding.answer)
        shapes[answer.candidate.key] = answer
        best = ranked(problem, prediction, others, shapes, np.flatnonzero(seeing(answer)))
        best = without_idle_curves(_material_answers(best, prediction), prediction)
        # A curve that is credible beside a formula has been added to it; otherwise the formula stays.
        formula = kind_of(finding.answer.candidate.effect).formula
        chosen = (_formula_first if formula else simplest)(prediction, best, total)
        selected = [*selected[:place], *([chosen] if chosen else []), *selected[place + 1 :]]
    return selected


def _changed_joints(before: Sequence[Selected], after: Sequence[Selected], joints: int) -> np.ndarray:
    """Joints that see a finding which only one of two lists contains, shape (n,)."""
    different = keys_of(before) ^ keys_of(after)
    changed = np.zeros(joints, bool)
    for finding in (*before, *after):
        if finding.answer.candidate.key in different:
            changed |= seeing(finding.answer)
    return changed


def _less_probable(problem: Problem, after: Sequence[Selected], before: Sequence[Selected]) -> bool:
    """Whether blocks are less probable with the findings `after` than with the findings `before`."""
    new, old = (problem.prediction(answers_of(findings)) for findings in (after, before))
    independent = old.weighting.independent
    gain = new.log_probability(new.errors, independent) - old.log_probability(old.errors, independent)
    return float(gain.sum()) < 0.0


def _material_answers(answers: Sequence[Answer], prediction: Prediction) -> list[Answer]:
    """Answers that make blocks more probable, and whose effect is material."""
    return [answer for answer in answers if answer.gain > 0.0 and _material(answer, prediction)]


def _material(answer: Answer, prediction: Prediction) -> bool:
    """Whether an effect explains more of the residual than errors in the formulas of other effects could.

    This is judged on the joint that shows it best, by the common variance of blocks. A smooth torque must
    also exceed the sensors' error of the joint's usual torque.
    """
    joint = answer.joint
    before, explained = explained_variance(prediction, answer, joint)
    least, usual = FORMULA**2 * before, answer.columns.usual
    if answer.candidate.smooth and usual is not None and joint in answer.columns.joints:
        least = max(least, (LINEAR * usual[answer.columns.joints == joint][0]) ** 2)
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
        problem, selected = _at_own_load(problem, selected)
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


def _at_own_load(problem: Problem, selected: Sequence[Selected]) -> tuple[Problem, list[Selected]]:
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
