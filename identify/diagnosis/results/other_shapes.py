"""Other shapes: how far the numbers of a finding vary over all shapes that the data allow.

Derivatives describe the uncertainty near the best shape only. A shape far away may predict the blocks almost
as well: a balancer with its angle mirrored, or Stribeck friction that fades with another power of the speed.
So each number of a shape is held at each value that was tried, the others are refined, and the shapes are
weighted by their probability, with the error of their formula among the unknowns.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from ..questions.block_answer import Answer
from ..questions.comparison import weighted
from ..questions.question import ask
from ..questions.shape import along
from ..search.search import SearchResult
from ..search.selected import answers_of

FAR = 20.0
"""Loss in log probability of a tried shape beyond which its other numbers cannot make it likely: a grid step
costs several."""


def deviations_over_shapes(result: SearchResult, place: int) -> tuple[np.ndarray, Mapping[str, float]]:
    """Root mean square deviation of each number of a finding from its best value over all likely shapes.

    Returns:
        Of the coefficients, shape (p,), and of the numbers of its shape; zero where no other shape was tried.
    """
    answer = result.selected[place].answer
    names, count = [*answer.candidate.names, *answer.candidate.bounds], len(answer.values)
    turn = np.array([shape.unit == "rad" for shape in answer.candidate.bounds.values()]) * 2 * np.pi
    most, best, turns = np.zeros(len(names)), None, np.append(np.zeros(count), turn)
    for profile in _profiles(result, place):
        best = best or _weighed(result, place, answer)
        members = [best, *(_weighed(result, place, shape) for shape in profile)]
        gains = np.array([gain for gain, _ in members])
        apart = np.array([numbers - best[1] for _, numbers in members])
        apart -= turns * np.round(apart / (2 * np.pi))
        weights = np.exp(gains - gains.max())
        most = np.maximum(most, np.sqrt(weights @ apart**2 / weights.sum()))
    return most[:count], dict(zip(names[count:], most[count:].tolist(), strict=True))


def _profiles(result: SearchResult, place: int) -> Iterator[list[Answer]]:
    """For each number of the shape, the likely shapes with its tried values, the other numbers refined."""
    answer, problem = result.selected[place].answer, result.problem
    own = answer.candidate
    grid = problem.pairs(lambda other, _: other.key == own.key) if own.bounds else []
    grid = [pair for pair in grid if (pair[0].names, [*pair[0].bounds]) == (own.names, [*own.bounds])]
    if len(grid) < 2:
        return
    others = [finding.answer for finding in result.selected if finding.answer is not answer]
    prediction = problem.prediction(others, result.prediction)
    answers = ask(prediction, [*grid, (own, answer.columns)])
    answers = [weighted(prediction, shape, answer.independent) for shape in answers]
    least = max(map(_gain, answers), default=0.0) - FAR
    likely = sorted((shape for shape in answers if _gain(shape) > least), key=_gain)
    for held in own.bounds:
        if len({candidate.shape[held] for candidate, _ in grid}) < 2:
            continue
        # The best shape with each value stays, since the last one replaces the others.
        shapes = {shape.candidate.shape[held]: shape for shape in likely if shape.candidate is not own}
        for name in [name for name in own.bounds if name != held]:
            shapes = {at: along(prediction, shape, problem.runs, name)[0] for at, shape in shapes.items()}
        if shapes:
            yield list(shapes.values())


def _gain(answer: Answer) -> float:
    """Gain in log probability, without the cost of choosing the shape."""
    return answer.gain + answer.cost


def _weighed(result: SearchResult, place: int, member: Answer) -> tuple[float, np.ndarray]:
    """Log probability of all fitted blocks with a shape among the findings, and all its numbers (q,)."""
    answers = answers_of(result.selected)
    others = [answer for number, answer in enumerate(answers) if number != place]
    prediction = result.problem.prediction([*others, member], result.prediction)
    gains = prediction.log_probability(prediction.errors, result.prediction.weighting.independent)
    coefficients = prediction.values[len(prediction.values) - len(member.values) :]
    shape = [member.candidate.shape[name] for name in member.candidate.bounds]
    return float(gains[member.fitted].sum()), np.append(coefficients, shape)
