"""Shape: the nonlinear numbers of an effect, searched for what predicts the blocks best."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import optimize

from ..blocks.prediction import Prediction
from ..runs.driven import Driven
from .block_answer import Answer
from .candidate import Candidate, Thinned
from .comparison import colouring, weighed
from .question import ask

APART = 0.5
"""Loss of the logarithm of the probability at which two shapes are one standard deviation apart."""
SWEEPS = 6
"""Times that all numbers of a shape are searched, one after the other, at most."""
WORTH = 2.0
"""Logarithm of the likelihood ratio from which on a further sweep is worth the time."""
TOGETHER, FIRST = 40, 0.1
"""Evaluations of a search of all numbers at once, and its first step over the bounds [-]."""
REFINED = 8
"""Evaluations that the search of one number takes: of its grid's step to some per cent."""


def refined(
    prediction: Prediction,
    answer: Answer,
    runs: Sequence[Driven],
    grid: Sequence[tuple[Candidate, Thinned]] = (),
) -> Answer:
    """The answer in its best shape between the neighbours on its grid.

    It costs as much as the number of shapes that blocks distinguish within the bounds. That number is too
    large where the numbers of a shape replace one another: it costs no more than the grid's mean does worse.
    The nearer the search comes, the more rows are independent, so that they are counted anew in each sweep.
    """
    best, choices = answer, dict.fromkeys(answer.candidate.bounds, 0.0)
    for _ in range(SWEEPS):
        best = colouring(prediction, best)
        before = best.gain
        for name in choices:
            best, choices[name] = _along(prediction, best, runs, name)
        if len(choices) < 2 or best.gain < before + WORTH:
            break
    if len(choices) > 1:
        best = _together(prediction, colouring(prediction, best), runs)
    best = weighed(prediction, best, answer.independent)
    cost = max(best.cost, float(np.log(best.candidate.among)) + sum(choices.values()))
    return replace(best, cost=min(cost, _over_grid(prediction, best, grid)))


def _over_grid(prediction: Prediction, best: Answer, grid: Sequence[tuple[Candidate, Thinned]]) -> float:
    """By how much the mean probability of a grid's shapes is less than that of the best, on a logarithm."""
    every = [weighed(prediction, one, best.independent) for one in ask(prediction, grid)]
    gains = [one.gain + one.cost for one in every]
    mean = np.logaddexp.reduce(gains) - np.log(len(grid)) if gains else -np.inf
    return float(best.gain + best.cost - mean)


def _along(prediction: Prediction, start: Answer, runs: Sequence[Driven], name: str) -> tuple[Answer, float]:
    """Vary one number, on a logarithm where its bounds are far apart and above zero; with what it costs."""
    bounds = start.candidate.bounds[name]
    apart = bounds.low > 0 and bounds.high / bounds.low > 5
    at = start.candidate.shape[name]
    quarter = 0.25 * (bounds.high - bounds.low)
    low, high = (at / 2.5, at * 2.5) if apart else (at - quarter, at + quarter)
    span = np.array([max(bounds.low, low), min(bounds.high, high)])
    scaled = np.log if apart else np.asarray
    tried = [(float(scaled(at)), start)]

    def loss(value: float) -> float:
        one = with_shape(prediction, start, runs, {name: float(np.exp(value) if apart else value)})
        tried.extend([] if one is None else [(value, one)])
        return 1e9 if one is None else -one.gain

    bracket = tuple(scaled(span))
    if bracket[1] > bracket[0]:
        optimize.minimize_scalar(loss, bounds=bracket, method="bounded", options={"maxiter": REFINED})
    place, best = max(tried, key=lambda pair: pair[1].gain)
    whole = float(scaled(bounds.high) - scaled(bounds.low))
    return best, _choice([(abs(value - place), best.gain - one.gain) for value, one in tried], whole)


def _together(prediction: Prediction, start: Answer, runs: Sequence[Driven]) -> Answer:
    """Vary all numbers of a shape at once, for those that replace one another."""
    names = list(start.candidate.bounds)
    bounds = [start.candidate.bounds[name] for name in names]
    size = np.array([one.high - one.low for one in bounds])
    at = np.array([start.candidate.shape[name] for name in names])
    tried = [start]

    def loss(values: np.ndarray) -> float:
        if any(not one.low <= value <= one.high for one, value in zip(bounds, values, strict=True)):
            return 1e9
        shape = dict(zip(names, map(float, values), strict=True))
        one = with_shape(prediction, start, runs, shape)
        tried.extend([] if one is None else [one])
        return 1e9 if one is None else -one.gain

    steps = np.minimum(FIRST * size, 0.5 * np.maximum(np.abs(at), FIRST * size))
    corners = np.vstack([at, at + np.diag(steps)])
    options = {"maxfev": TOGETHER, "initial_simplex": corners}
    optimize.minimize(loss, at, method="Nelder-Mead", options=options)
    return max(tried, key=lambda one: one.gain)


def _choice(tried: Sequence[tuple[float, float]], whole: float) -> float:
    """Logarithm of the number of shapes that blocks distinguish within the whole range of a number.

    Tried are distances from the best, and by how much less probable the blocks are there.
    """
    apart = [(distance, loss) for distance, loss in tried if loss > APART]
    if not apart:
        return 0.0
    distance, loss = min(apart)
    width = np.sqrt(2 * np.pi) * distance / np.sqrt(2 * loss)
    return max(float(np.log(whole / width)), 0.0)


def with_shape(
    prediction: Prediction, answer: Answer, runs: Sequence[Driven], shape: dict[str, float]
) -> Answer | None:
    """The answer of the same candidate in another shape; None where physics excludes it."""
    candidate = reshaped(answer.candidate, shape)
    found = ask(prediction, [(candidate, Thinned.of(candidate, runs))], strange=True)
    if not found:
        return None
    # Weighed as the answer is: of two shapes the faster one would have more independent rows.
    return weighed(prediction, found[0], answer.independent).chosen_as(answer)


def reshaped(candidate: Candidate, shape: dict[str, float]) -> Candidate:
    """The candidate with some numbers of its shape changed."""
    own = {name: candidate.shape[name] for name in candidate.bounds}
    return replace(candidate.reshaped(own | shape), among=candidate.among)


class Shaped(NamedTuple):
    """A hypothesis in the shape that was found."""

    effect: str  # name in the vocabulary
    joints: tuple[int, ...]  # from 0
    kind: str  # as of the candidate
    shape: dict[str, float]  # numbers that were searched

    @classmethod
    def of(cls, candidate: Candidate) -> "Shaped":
        """The shape of a candidate."""
        return cls(*candidate.key, {name: float(candidate.shape[name]) for name in candidate.bounds})


def asked_again(every: Sequence[Candidate], before: Sequence[Shaped]) -> Iterator[Candidate]:
    """Candidates in shapes that an earlier search has found, those that can be asked for in this model.

    The grid is too coarse for a resonance that is hardly damped: between its places none comes near.
    """
    by_key = {one.key: one for one in every if one.bounds and one.reshape is not None}
    for one in before:
        alike = by_key.get((one.effect, one.joints, one.kind))
        if alike is not None and set(one.shape) == set(alike.bounds):
            yield alike.reshaped(one.shape)
