"""Search: findings are added, replaced and removed until no step makes the runs more probable."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..blocks.prediction import Prediction
from ..candidates import KINDS, kind_of
from ..questions.block_answer import CERTAIN_ODDS, Answer
from ..questions.candidate import Candidate, Thinned
from ..questions.comparison import seeing
from ..questions.question import ask
from ..questions.shape import refined
from .additions import (
    advantage,
    at_own_load,
    formula_first,
    material_answers,
    with_additions,
    without_idle_curves,
)
from .checks import checked_by_held_out, harmful, with_refined_shape
from .held_out import proven, shown_by_held_out, supported
from .problem import Problem
from .ranking import Shapes, ranked, total_prior
from .selected import Selected, answers_of, keys_of, odds_of
from .simpler import simplest

PASSES = 6
"""Maximum number of passes: most searches converge in two or three; in some, findings keep alternating."""
CHECKS = 2
"""Maximum number of checks by held-out runs: the search continues without what they contradict."""


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of a search."""

    problem: Problem  # runs and candidates
    selected: tuple[Selected, ...]  # findings in the order of their columns, largest first
    prediction: Prediction  # prediction with the columns of all findings, which are the last of its rows
    without_findings: Prediction  # prediction of the baseline
    shapes: Shapes = field(default_factory=dict)  # best shapes of hypotheses
    out: frozenset[object] = frozenset()  # keys of hypotheses that held-out runs contradict

    def ordered(self) -> "SearchResult":
        """The same result, with the findings that are certain enough to be named first."""
        selected = sorted(self.selected, key=lambda finding: not finding.named)
        return replace(
            self, selected=tuple(selected), prediction=self.problem.prediction(answers_of(selected))
        )


def search(problem: Problem, start: SearchResult | None = None, brief: bool = False) -> SearchResult:
    """Find the effects that the model lacks.

    Findings are added, replaced and removed until no step makes the fitted blocks more probable. Then
    held-out runs judge the torque that the findings predict, and the search continues without those that they
    contradict.

    In a brief search, each finding is replaced at most once, and held-out runs only remove.
    """
    passes, checks = (1, 1) if brief else (PASSES, CHECKS)
    without_findings = problem.without_findings
    shapes: Shapes = start.shapes if start else {}
    selected = list(start.selected) if start else _measured_effects(problem, without_findings)
    problem = problem.with_candidates(_suggested_by_baseline(problem, without_findings))
    total, out = total_prior(problem), set[object]()
    for _ in range(checks):
        problem, selected = _converged(problem, selected, total, shapes, out, passes)
        checked = supported(problem, checked_by_held_out(problem, selected, without_findings, total))
        gone = keys_of(selected) - keys_of(checked)
        selected, out = checked, out | gone
        if not gone:
            break
    selected = proven(problem, selected)
    prediction = problem.prediction(answers_of(selected))
    return SearchResult(problem, tuple(selected), prediction, without_findings, shapes, frozenset(out))


def with_shown(result: SearchResult) -> SearchResult:
    """The result with undecided findings that only the held-out runs make credible."""
    problem, out = result.problem, result.out
    answers = ranked(problem, result.prediction, result.selected, result.shapes)
    open_ = [answer for answer in answers if answer.candidate.key not in out]
    selected = result.selected
    for finding in sorted(shown_by_held_out(open_, total_prior(problem)), key=lambda shown: -shown.odds):
        if not harmful(problem, [*selected, finding], result.without_findings):
            selected = (*selected, finding)
    prediction = problem.prediction(answers_of(selected))
    return replace(result, selected=selected, prediction=prediction)


def _converged(
    problem: Problem, selected: list[Selected], total: float, shapes: Shapes, out: set[object], passes: int
) -> tuple[Problem, list[Selected]]:
    """Findings to which no addition, replacement or removal makes the fitted blocks more probable."""
    before, visited = list(selected), list[list[Selected]]()
    for _ in range(passes):
        for key in [key for key, answer in shapes.items() if answer.strange]:
            del shapes[key]  # beside other findings it may be possible
        searched, added = with_additions(problem, selected, total, shapes, out)
        problem, added = at_own_load(searched, added)
        if problem is not searched:
            searched.forget()
        changed = _changed_evidence(before, added, problem.without_findings.joints)
        before = selected = _rechosen(problem, added, total, changed, shapes, out)
        if keys_of(selected) == keys_of(added):
            return problem, selected
        alternating = keys_of(selected) in map(keys_of, visited)
        visited.append(selected)
        if alternating:
            break
    for findings in visited:
        if advantage(problem, findings, selected, total) > 0.0:
            selected = findings
    return at_own_load(problem, selected)


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


def _rechosen(
    problem: Problem,
    selected: list[Selected],
    total: float,
    changed: np.ndarray,
    shapes: Shapes,
    out: set[object],
) -> list[Selected]:
    """Each finding replaced by the most probable hypothesis given all others; removed if none is credible.

    A finding stays if its rivals are further behind than all that has changed on its joints since it was
    chosen, in log odds: a rival then had to gain more than any of the changes is worth.
    """
    with_all = problem.prediction(answers_of(selected))
    for finding in list(selected):
        change = np.max(changed[seeing(finding.answer)], initial=0.0)
        ahead = all(odds > change for _, odds in finding.others)
        alone = not finding.others and finding.answer.candidate.bounds
        if finding.once or change <= 0.0 or (ahead and not alone):
            continue
        place, others = selected.index(finding), [other for other in selected if other is not finding]
        prediction = problem.prediction(answers_of(others), with_all)
        answer = with_refined_shape(problem, prediction, finding.answer)
        shapes[answer.candidate.key] = answer
        chosen = _most_probable(problem, prediction, others, answer, total, shapes, out)
        selected = [*selected[:place], *([chosen] if chosen else []), *selected[place + 1 :]]
    return selected


def _most_probable(
    problem: Problem,
    prediction: Prediction,
    others: list[Selected],
    answer: Answer,
    total: float,
    shapes: Shapes,
    out: set[object],
) -> Selected | None:
    """The most probable hypothesis on the joints that see an answer, given the other findings."""
    best = ranked(problem, prediction, others, shapes, np.flatnonzero(seeing(answer)))
    open_ = [other for other in material_answers(best, prediction) if other.candidate.key not in out]
    best = without_idle_curves(open_, prediction)
    # A curve that is credible beside a formula has been added to it; otherwise the formula stays.
    formula = kind_of(answer.candidate.effect).formula
    return (formula_first if formula else simplest)(prediction, best, total)


def _changed_evidence(before: Sequence[Selected], after: Sequence[Selected], joints: int) -> np.ndarray:
    """Log odds of the findings that only one of two lists contains, summed over those a joint sees, (n,)."""
    different = keys_of(before) ^ keys_of(after)
    changed = np.zeros(joints)
    for finding in (*before, *after):
        if finding.answer.candidate.key in different:
            changed += np.where(seeing(finding.answer), max(finding.odds, CERTAIN_ODDS), 0.0)
    return changed
