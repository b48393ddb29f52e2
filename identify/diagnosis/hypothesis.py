"""Hypotheses: candidates weighed against what remains, shape by shape, and the best shape found."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize

from .candidate import Candidate, Thinned
from .driven import Driven
from .solution import CERTAIN, Profile, Solution

SWEEPS = 2
"""Times that all numbers of a shape are searched, one after the other: how long a link floats in its play
and when it begins to are found together only."""
WORTH = 2.0
"""Logarithm of the likelihood ratio from which on a shape, or a further sweep, is worth the time."""
SCALES = (0.1, 1 / 3, 1.0, 3.0, 10.0)
"""Of an effect over how large it is expected: from a hundredth of a joint's usual torque to all of it."""
STRANGE = 4.0
"""Standard deviations from what physics expects at which something is not that effect: one in 16 000."""
TOGETHER = 32
"""Candidates that are weighed at once: some megabytes of columns."""
REFINED = 8
"""Evaluations that the search of one shape takes: of its grid's step to some per cent."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One effect on certain joints, weighed.

    Attributes:
        candidate: In its best shape.
        columns: Its columns.
        values: Its coefficients, shape (p,).
        evidence: Logarithm of the Bayes factor against nothing more, its shapes being equally likely.
        own: The same of the best shape and size alone.
        scale: Size that it is believed to have, over that of its columns [-].
    """

    candidate: Candidate
    columns: Thinned
    values: np.ndarray
    evidence: float
    own: float
    scale: float = 1.0

    @property
    def std(self) -> np.ndarray:
        """How far each coefficient may be from what is expected, shape (p,)."""
        return self.scale * self.columns.std

    @property
    def found_std(self) -> np.ndarray:
        """How far each coefficient may be from its mean once the effect is taken to be there, shape (p,).

        One that physics does not let below zero, and that would go there, stays at zero: it is a detail of
        the effect that these runs do not show, and no reason against the rest.
        """
        believed = np.hypot(self.columns.mean, self.std)
        wide = believed * max(1.0, float(np.max(np.abs(self.values) / believed)))
        at_limit = (self.values == 0.0) & (np.array(self.candidate.lower) == 0.0)
        return np.where(at_limit, CERTAIN, np.where(self.found_mean > 0.0, self.std, wide))

    @property
    def found_mean(self) -> np.ndarray:
        """What each coefficient is believed to be then, shape (p,): zero unless it is known to be whole."""
        return np.where(self.columns.whole, self.columns.mean, 0.0)

    @property
    def torque(self) -> np.ndarray:
        """Its torque, shape (r, k) of the joints of its columns [N m]."""
        return self.columns.values @ self.values


def weigh(solution: Solution, thinned: Iterable[tuple[Candidate, Thinned]]) -> list[Hypothesis]:
    """All hypotheses, the most credible first; shapes of one effect and place are averaged."""
    groups: dict[object, list[Hypothesis]] = {}
    for alike in _together(thinned):
        profiles = solution.profiles([columns.values for _, columns in alike], alike[0][1].joints)
        for (candidate, columns), profile in zip(alike, profiles, strict=True):
            groups.setdefault(candidate.key, []).append(judged(profile, candidate, columns))
    found = []
    for group in groups.values():
        best = max(group, key=lambda one: one.evidence)
        logs = np.array([one.evidence for one in group])
        finite = logs[np.isfinite(logs)]
        count = max(len(logs), best.candidate.among)
        mean = np.logaddexp.reduce(finite) - np.log(count) if len(finite) else -np.inf
        found.append(replace(best, evidence=float(mean)))
    return sorted(found, key=lambda one: -one.evidence)


def _together(thinned: Iterable[tuple[Candidate, Thinned]]) -> Iterator[list[tuple[Candidate, Thinned]]]:
    """Candidates of the same joints, some at a time."""
    by_joints: dict[tuple[int, ...], list[tuple[Candidate, Thinned]]] = {}
    for pair in thinned:
        if not pair[1].empty:
            by_joints.setdefault(tuple(pair[1].joints), []).append(pair)
    for alike in by_joints.values():
        yield from (alike[start : start + TOGETHER] for start in range(0, len(alike), TOGETHER))


def weighed(solution: Solution, candidate: Candidate, columns: Thinned) -> Hypothesis:
    """One candidate in one shape, averaged over how large its effect may be."""
    return judged(solution.profile(columns.values, columns.joints), candidate, columns)


def judged(whole: Profile, candidate: Candidate, columns: Thinned) -> Hypothesis:
    """The same from its profile."""
    profile, gain = whole.about(columns.mean)
    lower = np.array(candidate.lower) - columns.mean
    scales = SCALES if candidate.expected is None else (1.0,)
    tried = [profile.best(scale * columns.std, lower) for scale in scales]
    best = int(np.argmax([evidence for _, evidence in tried]))
    evidence = float(np.logaddexp.reduce([one for _, one in tried]) - np.log(len(scales)) + gain)
    gain += float(np.log(candidate.prior))
    evidence += float(np.log(candidate.prior))
    values, own = tried[best][0] + columns.mean, float(tried[best][1] + gain)
    if strange(columns, values):
        evidence = own = -np.inf
    return Hypothesis(candidate, columns, values, evidence, own, scales[best])


def strange(columns: Thinned, values: np.ndarray) -> bool:
    """Whether coefficients (p,) are another effect's, where physics says how large they are."""
    known = columns.mean != 0.0
    return bool(np.any(np.abs(values - columns.mean)[known] > STRANGE * columns.std[known]))


def refined(solution: Solution, hypothesis: Hypothesis, runs: Sequence[Driven]) -> Hypothesis:
    """The hypothesis in the shape that explains most, between the neighbours on its grid."""
    best = reshaped(solution, hypothesis, runs)
    # The search looks at more shapes than the grid; the average over the grid stays the evidence.
    tried = len(SCALES) * max(2 * REFINED, hypothesis.candidate.among)
    return replace(best, evidence=max(hypothesis.evidence, best.own - np.log(tried)))


def reshaped(solution: Solution, hypothesis: Hypothesis, runs: Sequence[Driven]) -> Hypothesis:
    """The hypothesis in its best shape, at the same cost of choosing one."""
    cost = hypothesis.own - hypothesis.evidence
    best = weighed(solution, hypothesis.candidate, hypothesis.columns)
    for _ in range(SWEEPS):
        before = best.own
        for name, bounds in best.candidate.bounds.items():
            best = _along(solution, best, runs, name, (bounds.low, bounds.high))
        if len(best.candidate.bounds) < 2 or not best.own > before + WORTH:
            break
    return replace(best, evidence=best.own - cost)


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
