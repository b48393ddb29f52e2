"""Hypotheses: candidates weighed against what remains, shape by shape, and the best shape found."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize

from .candidate import Candidate, Thinned
from .driven import Driven
from .solution import Solution

REFINED = 12
"""Evaluations that the search of one shape takes: a golden section of its grid's step to three per cent."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One effect on certain joints, weighed.

    Attributes:
        candidate: In its best shape.
        columns: Its columns.
        values: Its coefficients, shape (p,).
        evidence: Logarithm of the Bayes factor against nothing more, its shapes being equally likely.
    """

    candidate: Candidate
    columns: Thinned
    values: np.ndarray
    evidence: float

    @property
    def torque(self) -> np.ndarray:
        """Its torque, shape (r, k) of the joints of its columns [N m]."""
        return self.columns.values @ self.values


def weigh(solution: Solution, thinned: Iterable[tuple[Candidate, Thinned]]) -> list[Hypothesis]:
    """All hypotheses, the most credible first; shapes of one effect and place are averaged."""
    groups: dict[object, list[Hypothesis]] = {}
    for candidate, columns in thinned:
        if not columns.empty:
            groups.setdefault(candidate.key, []).append(weighed(solution, candidate, columns))
    found = []
    for group in groups.values():
        best = max(group, key=lambda one: one.evidence)
        logs = np.array([one.evidence for one in group])
        finite = logs[np.isfinite(logs)]
        count = max(len(logs), best.candidate.among)
        mean = np.logaddexp.reduce(finite) - np.log(count) if len(finite) else -np.inf
        found.append(replace(best, evidence=float(mean)))
    return sorted(found, key=lambda one: -one.evidence)


def weighed(solution: Solution, candidate: Candidate, columns: Thinned) -> Hypothesis:
    """One candidate in one shape."""
    whole = solution.profile(columns.values, columns.joints)
    profile, gain = whole.about(columns.mean)
    apart, evidence = profile.best(columns.std, np.array(candidate.lower) - columns.mean)
    values = apart + columns.mean
    return Hypothesis(candidate, columns, values, evidence + gain)


def refined(solution: Solution, hypothesis: Hypothesis, runs: Sequence[Driven]) -> Hypothesis:
    """The hypothesis in the shape that explains most, between the neighbours on its grid."""
    best = hypothesis
    for name, bounds in hypothesis.candidate.bounds.items():
        best = _along(solution, best, runs, name, (bounds.low, bounds.high))
    # The search looks at more shapes than the grid; the average over the grid stays the evidence.
    tried = max(2 * REFINED, hypothesis.candidate.among)
    return replace(best, evidence=max(hypothesis.evidence, best.evidence - np.log(tried)))


def _along(
    solution: Solution, start: Hypothesis, runs: Sequence[Driven], name: str, limits: tuple[float, float]
) -> Hypothesis:
    """Vary one number of the shape, on a logarithm where its bounds are far apart."""
    low, high = limits
    apart = low > 0 and high / low > 5
    at = start.candidate.shape[name]
    span = (max(low, at / 2.5), min(high, at * 2.5)) if apart else (
        max(low, at - 0.25 * (high - low)), min(high, at + 0.25 * (high - low))
    )  # fmt: skip
    tried = {at: weighed(solution, start.candidate, start.columns)}

    def loss(value: float) -> float:
        value = float(np.exp(value) if apart else value)
        assert start.candidate.reshaped is not None
        candidate = start.candidate.reshaped({**_free(start.candidate), name: value})
        tried[value] = weighed(solution, candidate, Thinned.of(candidate, runs))
        return -max(tried[value].evidence, -1e9)

    bracket = np.log(span) if apart else np.array(span)
    optimize.minimize_scalar(loss, bounds=tuple(bracket), method="bounded", options={"maxiter": REFINED})
    return max(tried.values(), key=lambda one: one.evidence)


def _free(candidate: Candidate) -> dict[str, float]:
    return {name: candidate.shape[name] for name in candidate.bounds}
