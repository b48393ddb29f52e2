"""Distinction: how reliably a run distinguishes each pair of hypotheses, and remedies if no motion can."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits
from exidyn.identification.text_table import percent

from .discriminate import Discriminate, Pair
from .remedies import REMEDIES, Remedy
from .separation import Explanation, Hypothesis, Observation, explain, probability, separation_for

STATES = 1000
"""Number of random states of the arm from which the most informative are chosen."""
STEPS = 30
"""Maximum number of steps of that search; nearly every pair is decided by the third."""


def most_informative(
    true: Hypothesis,
    rival: Hypothesis,
    observation: Observation,
    limits: Limits,
    rows: float,
    wanted: float = np.nan,
) -> tuple[float, float]:
    """Lower and upper bound of the separation that rows at the most informative states achieve.

    The states need not form a motion, so no motion achieves more. Let weights w over the states sum to the
    number of rows. With the rival's best parameters for w, the separation is a lower bound of the optimum.
    Any parameters of the rival give an upper bound: all rows at the state with the largest residual. Weights
    are multiplied by the squared residual until both bounds are on one side of `wanted`, or to the end if
    that is NaN. Limits must be finite; `rows` replaces the number of rows of the observation.
    """
    motion = states_within(limits, STATES)
    seen, torque = observation.seen(rival, motion), observation.seen(true, motion).torque
    kinds = len(observation.payloads)
    weight, low, high = np.full(STATES, rows / STATES), 0.0, np.inf
    for _ in range(STEPS):
        explanation = explain(rival, seen, torque, np.tile(weight, kinds))
        squared_residual = np.sum(explanation.residual**2, axis=1).reshape(kinds, STATES).sum(axis=0)
        held = explanation.separation - float(weight @ squared_residual)  # what its priors charge the rival
        low, high = max(low, explanation.separation), min(high, rows * float(squared_residual.max()) + held)
        if low >= wanted or high < wanted or high - low <= 0.01 * high:
            break
        weight = rows * weight * squared_residual / float(weight @ squared_residual)
    return low, high


def states_within(limits: Limits, count: int, seed: int = 0) -> Motion:
    """Random states within limits, distributed like a sinusoid between them; half of them are slow."""
    random = np.random.default_rng(seed)

    def between(lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
        wave = np.sin(random.uniform(-np.pi, np.pi, (count, len(lower))))
        return 0.5 * (lower + upper) + 0.5 * (upper - lower) * wave

    position = between(limits.position_lower, limits.position_upper)
    velocity = between(limits.velocity_lower, limits.velocity)
    velocity[::2] *= 10.0 ** random.uniform(-3.0, 0.0, velocity[::2].shape)  # where friction reverses
    acceleration = between(limits.acceleration_lower, limits.acceleration)
    temperature = random.uniform(20.0, 50.0, velocity.shape)
    return Motion.of(np.arange(count) * 1.0, position, velocity, acceleration, temperature=temperature)


SURE = 0.95
"""Probability of choosing right from which two models count as distinguished."""
HOUR = 3600.0
"""Longest reasonable excitation of an arm [s]: a pair that it cannot distinguish remains open."""
MOST_RUNS = 128
"""Maximum number of runs of the same motion; more are not worthwhile."""


class Distinction(NamedTuple):
    """How well one pair of hypotheses can be distinguished."""

    pair: tuple[str, str]  # names of the hypotheses
    probability_before: float  # probability of choosing right from the data so far [-]
    probability_after: float  # probability of choosing right with one more run of the motion [-]
    # Number of runs, a power of two, that distinguish the pair; None if `MOST_RUNS` are not enough.
    runs: int | None
    probability_hour: float  # upper bound of the probability after an hour of any motion [-]
    possible: bool  # whether an hour of some motion may be enough
    # Probability of choosing right after repeating the run with a remedy, by its name, the best first; empty
    # if the motion distinguishes the pair.
    remedies: Mapping[str, float]


def distinguish(
    goal: Discriminate, motion: Motion, limits: Limits, seconds: float, remedies: Sequence[Remedy] = REMEDIES
) -> list[Distinction]:
    """How well a motion distinguishes every pair of a goal's hypotheses.

    The run takes `seconds` [s]; remedies are evaluated for pairs that it leaves open.
    """
    explanations, distinctions = goal.explanations(motion), []
    for pair in combinations(range(len(goal.hypotheses)), 2):
        orders = (pair, pair[::-1])
        before = min(goal.earlier[order] for order in orders)
        after = probability(min(goal.earlier[order] + explanations[order].separation for order in orders))
        rows = goal.observation.rows * HOUR / seconds
        hour = probability(min(_largest_separation(goal, order, limits, rows) for order in orders))
        tried = () if after >= SURE else remedies
        offers = [_offer(goal, motion, remedy, explanations, pair) for remedy in tried]
        best_first = sorted(offers, key=lambda offer: -offer[1])
        distinctions.append(
            Distinction(
                pair=(goal.hypotheses[pair[0]].name, goal.hypotheses[pair[1]].name),
                probability_before=probability(before),
                probability_after=after,
                runs=_runs(goal, motion, pair),
                probability_hour=hour,
                possible=hour >= SURE,
                remedies=dict(best_first),
            )
        )
    return distinctions


def _offer(
    goal: Discriminate, motion: Motion, remedy: Remedy, explanations: dict[Pair, Explanation], pair: Pair
) -> tuple[str, float]:
    """Name of a remedy, and the probability after two runs, the second with the remedy."""
    totals = []
    for true, rival in (pair, pair[::-1]):
        first = explanations[true, rival]
        case = remedy((goal.hypotheses[true], first.hypothesis), motion, goal.observation)
        seen = [case.observation.seen(hypothesis, motion) for hypothesis in case.hypotheses]
        second = explain(case.hypotheses[1], seen[1], seen[0].torque, case.observation.rows / len(motion))
        totals.append(goal.earlier[true, rival] + first.separation + second.separation)
    return case.name, probability(min(totals))


def _runs(goal: Discriminate, motion: Motion, pair: Pair) -> int | None:
    """Number of runs of the motion, a power of two, that distinguish a pair; None if there are too many."""
    wanted, share = separation_for(SURE), goal.observation.rows / len(motion)
    seen = {place: goal.observation.seen(goal.hypotheses[place], motion) for place in pair}
    runs = 1
    while runs <= MOST_RUNS:
        totals = [
            goal.earlier[true, rival]
            + explain(goal.hypotheses[rival], seen[rival], seen[true].torque, runs * share).separation
            for true, rival in (pair, pair[::-1])
        ]
        if min(totals) >= wanted:
            return runs
        runs *= 2
    return None


def _largest_separation(goal: Discriminate, order: Pair, limits: Limits, rows: float) -> float:
    """Upper bound of the separation that a number of rows of any motion can reach."""
    true, rival = (goal.hypotheses[place] for place in order)
    earlier = float(goal.earlier[order])
    bounds = most_informative(true, rival, goal.observation, limits, rows, separation_for(SURE) - earlier)
    return earlier + bounds[1]


def paragraph(distinction: Distinction) -> str:
    """What a run and other motions show about one pair, in words."""
    text = (
        f"{distinction.pair[0]} or {distinction.pair[1]}: the probability of choosing right is "
        f"{percent(distinction.probability_before, 3)} before the run and "
        f"{percent(distinction.probability_after, 3)} after."
    )
    if distinction.probability_after >= SURE:
        return text
    if not distinction.possible:
        text += (
            " No motion distinguishes them: an hour at the most informative states within the limits "
            f"reaches at most {percent(distinction.probability_hour, 3)}."
        )
    elif distinction.runs is not None:
        text += f" About {distinction.runs} such runs distinguish them."
    else:
        text += f" More than {MOST_RUNS} such runs would be needed."
    helping, others = list[str](), list[str]()
    for name, chance in distinction.remedies.items():
        (helping if chance >= SURE else others).append(f"{name} ({percent(chance, 3)})")
    if helping:
        text += f" To distinguish them, repeat the run with {' or '.join(helping)}."
    if others:
        text += f" Not sufficient: {', '.join(others)}."
    return text
