"""Shape: the nonlinear parameters of an effect, optimized for the best prediction of the blocks."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import optimize

from ..blocks.prediction import Prediction
from ..runs.driven import Driven
from .block_answer import Answer
from .candidate import Candidate, Thinned
from .comparison import colouring, weighted
from .question import ask

APART = 0.5
"""Loss in log probability that corresponds to one standard deviation."""
SWEEPS = 6
"""Maximum number of sweeps over the parameters of a shape, one parameter at a time."""
WORTH = 2.0
"""Log likelihood ratio from which on a further sweep is worth the time."""
TOGETHER, FIRST = 40, 0.1
"""Evaluations of a search over all parameters at once, and its first step relative to the bounds [-]."""
REFINED = 8
"""Evaluations of a search over one parameter: enough to narrow a grid step to a few percent."""


def refined(
    prediction: Prediction,
    answer: Answer,
    runs: Sequence[Driven],
    grid: Sequence[tuple[Candidate, Thinned]] = (),
) -> Answer:
    """The answer in its best shape between the neighbors on its grid.

    The cost is the log of the number of shapes that blocks distinguish within the bounds. That number is too
    large where parameters of a shape are interchangeable, so the cost is at most the loss of the grid's mean.
    A better shape leaves a whiter residual, so independent rows are counted again in each sweep.
    """
    best, choices = answer, dict.fromkeys(answer.candidate.bounds, 0.0)
    for _ in range(SWEEPS):
        best = colouring(prediction, best)
        before = best.gain
        for name in choices:
            best, choices[name] = along(prediction, best, runs, name)
        if len(choices) < 2 or best.gain < before + WORTH:
            break
    if len(choices) > 1:
        best = _together(prediction, colouring(prediction, best), runs)
    best = weighted(prediction, best, answer.independent)
    cost = max(best.cost, float(np.log(best.candidate.among)) + sum(choices.values()))
    return replace(best, cost=min(cost, _over_grid(prediction, best, grid)))


def _over_grid(prediction: Prediction, best: Answer, grid: Sequence[tuple[Candidate, Thinned]]) -> float:
    """Log probability of the best shape minus that of the mean over a grid's shapes."""
    shapes = [weighted(prediction, answer, best.independent) for answer in ask(prediction, grid)]
    gains = [shape.gain + shape.cost for shape in shapes]
    mean = np.logaddexp.reduce(gains) - np.log(len(grid)) if gains else -np.inf
    return float(best.gain + best.cost - mean)


def along(prediction: Prediction, start: Answer, runs: Sequence[Driven], name: str) -> tuple[Answer, float]:
    """Vary one parameter, on a log scale if its bounds are positive and far apart; return the cost too."""
    bounds = start.candidate.bounds[name]
    log_scale = bounds.low > 0 and bounds.high / bounds.low > 5
    at = start.candidate.shape[name]
    quarter = 0.25 * (bounds.high - bounds.low)
    low, high = (at / 2.5, at * 2.5) if log_scale else (at - quarter, at + quarter)
    span = np.array([max(bounds.low, low), min(bounds.high, high)])
    scaled = np.log if log_scale else np.asarray
    tried = [(float(scaled(at)), start)]

    def loss(value: float) -> float:
        answer = with_shape(prediction, start, runs, {name: float(np.exp(value) if log_scale else value)})
        tried.extend([] if answer is None else [(value, answer)])
        return 1e9 if answer is None else -answer.gain

    bracket = tuple(scaled(span))
    if bracket[1] > bracket[0]:
        optimize.minimize_scalar(loss, bounds=bracket, method="bounded", options={"maxiter": REFINED})
    place, best = max(tried, key=lambda pair: pair[1].gain)
    extent = float(scaled(bounds.high) - scaled(bounds.low))
    return best, _choice([(abs(value - place), best.gain - answer.gain) for value, answer in tried], extent)


def _together(prediction: Prediction, start: Answer, runs: Sequence[Driven]) -> Answer:
    """Vary all parameters of a shape at once, since some may be interchangeable."""
    names = list(start.candidate.bounds)
    bounds = [start.candidate.bounds[name] for name in names]
    size = np.array([bound.high - bound.low for bound in bounds])
    at = np.array([start.candidate.shape[name] for name in names])
    tried = [start]

    def loss(values: np.ndarray) -> float:
        if any(not bound.low <= value <= bound.high for bound, value in zip(bounds, values, strict=True)):
            return 1e9
        shape = dict(zip(names, map(float, values), strict=True))
        answer = with_shape(prediction, start, runs, shape)
        tried.extend([] if answer is None else [answer])
        return 1e9 if answer is None else -answer.gain

    steps = np.minimum(FIRST * size, 0.5 * np.maximum(np.abs(at), FIRST * size))
    corners = np.vstack([at, at + np.diag(steps)])
    options = {"maxfev": TOGETHER, "initial_simplex": corners}
    optimize.minimize(loss, at, method="Nelder-Mead", options=options)
    return max(tried, key=lambda answer: answer.gain)


def _choice(tried: Sequence[tuple[float, float]], extent: float) -> float:
    """Log of the number of values of a parameter that blocks distinguish within its range."""
    distinguished = [(distance, loss) for distance, loss in tried if loss > APART]
    if not distinguished:
        return 0.0
    distance, loss = min(distinguished)
    width = np.sqrt(2 * np.pi) * distance / np.sqrt(2 * loss)
    return max(float(np.log(extent / width)), 0.0)


def with_shape(
    prediction: Prediction, answer: Answer, runs: Sequence[Driven], shape: dict[str, float]
) -> Answer | None:
    """The answer of the same candidate in another shape; None where physics excludes it."""
    candidate = reshaped(answer.candidate, shape)
    answers = ask(prediction, [(candidate, Thinned.of(candidate, runs))], strange=True)
    if not answers:
        return None
    # Both shapes get the same weights: a faster shape would otherwise have more independent rows.
    return weighted(prediction, answers[0], answer.independent).chosen_as(answer)


def reshaped(candidate: Candidate, shape: dict[str, float]) -> Candidate:
    """The candidate with some parameters of its shape changed."""
    current = {name: candidate.shape[name] for name in candidate.bounds}
    return replace(candidate.reshaped(current | shape), among=candidate.among)
