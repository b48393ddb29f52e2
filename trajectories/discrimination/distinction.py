"""Distinction: how surely a run distinguishes each pair of hypotheses, and what would where no motion can."""

from collections.abc import Sequence
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
"""Random states of the arm that the most informative are chosen from."""
STEPS = 30
"""Of the search for them; nearly every pair is decided by the third."""


def most_informative(
    true: Hypothesis,
    rival: Hypothesis,
    observation: Observation,
    limits: Limits,
    rows: float,
    wanted: float = np.nan,
) -> tuple[float, float]:
    """Lower and upper bound of the separation by rows at the most informative states.

    No motion is asked to join the states, so that none does better. With weights w over states that sum to
    the rows, and the rival's best parameters for them, the separation is a lower bound of the best; since
    any parameters of the rival are an upper bound for every w, so are all rows at the state where these
    leave the most. Weights are multiplied by what is left until the bounds are on one side of `wanted`.

    Args:
        true: The hypothesis that is true.
        rival: The one that explains it.
        observation: How torque is seen; its rows are not used.
        limits: Finite ones.
        rows: Independent rows.
        wanted: Separation of which only the side matters; NaN where the bounds do.
    """
    motion = states_within(limits, STATES)
    seen, torque = observation.seen(rival, motion), observation.seen(true, motion).torque
    kinds = len(observation.payloads)
    weight, low, high = np.full(STATES, rows / STATES), 0.0, np.inf
    for _ in range(STEPS):
        found = explain(rival, seen, torque, np.tile(weight, kinds))
        left = np.sum(found.residual**2, axis=1).reshape(kinds, STATES).sum(axis=0)
        held = found.separation - float(weight @ left)  # what its priors charge the rival
        low, high = max(low, found.separation), min(high, rows * float(left.max()) + held)
        if low >= wanted or high < wanted or high - low <= 0.01 * high:
            break
        weight = rows * weight * left / float(weight @ left)
    return low, high


def states_within(limits: Limits, count: int, seed: int = 0) -> Motion:
    """Random states within limits, near them as often as a sinusoid is, half of them slow."""
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
"""Longest reasonable excitation of an arm [s]: what this leaves open stays open."""
MOST_RUNS = 128
"""Of the same motion, beyond which repeating it is not worthwhile."""


class Offer(NamedTuple):
    """A remedy, and the probability of choosing right when the run is made once more with it [-]."""

    name: str
    probability: float


class Distinction(NamedTuple):
    """What is to be had for one pair of hypotheses.

    Attributes:
        pair: Their names.
        probability_before: Probability of choosing right by the data so far [-].
        probability_after: With one run of the motion as well [-].
        runs: Repetitions of the motion, doubled until they suffice; None if `MOST_RUNS` do not.
        probability_hour: Upper bound of what any motion does in an hour [-].
        possible: Whether that is enough.
        remedies: What else could be done, the best first; empty where the motion does.
    """

    pair: tuple[str, str]
    probability_before: float
    probability_after: float
    runs: int | None
    probability_hour: float
    possible: bool
    remedies: tuple[Offer, ...]


def distinguish(
    goal: Discriminate,
    motion: Motion,
    limits: Limits,
    seconds: float,
    remedies: Sequence[Remedy] = REMEDIES,
) -> list[Distinction]:
    """What a motion does for every pair of a goal's hypotheses.

    Args:
        goal: Hypotheses and how torque is seen.
        motion: Motion of one run.
        limits: Finite ones, within which other motions might be.
        seconds: Length of the run [s].
        remedies: What is asked for pairs that the run leaves open.
    """
    found = goal.explanations(motion)
    places = combinations(range(len(goal.hypotheses)), 2)
    return [_distinction(goal, motion, limits, seconds, remedies, found, pair) for pair in places]


def _distinction(
    goal: Discriminate,
    motion: Motion,
    limits: Limits,
    seconds: float,
    remedies: Sequence[Remedy],
    found: dict[Pair, Explanation],
    pair: Pair,
) -> Distinction:
    orders = (pair, pair[::-1])
    before = min(goal.earlier[order] for order in orders)
    after = probability(min(goal.earlier[order] + found[order].separation for order in orders))
    hour = min(_most(goal, order, limits, goal.observation.rows * HOUR / seconds) for order in orders)
    offers = [] if after >= SURE else [_offer(goal, motion, remedy, found, pair) for remedy in remedies]
    return Distinction(
        (goal.hypotheses[pair[0]].name, goal.hypotheses[pair[1]].name),
        probability(before),
        after,
        _runs(goal, motion, pair),
        probability(hour),
        probability(hour) >= SURE,
        tuple(sorted(offers, key=lambda offer: -offer.probability)),
    )


def _offer(
    goal: Discriminate, motion: Motion, remedy: Remedy, found: dict[Pair, Explanation], pair: Pair
) -> Offer:
    """Both runs together: as it is, then with the remedy."""
    totals = []
    for true, rival in (pair, pair[::-1]):
        first = found[true, rival]
        case = remedy((goal.hypotheses[true], first.hypothesis), motion, goal.observation)
        seen = [case.observation.seen(one, motion) for one in case.hypotheses]
        again = explain(case.hypotheses[1], seen[1], seen[0].torque, case.observation.rows / len(motion))
        totals.append(goal.earlier[true, rival] + first.separation + again.separation)
    return Offer(case.name, probability(min(totals)))


def _runs(goal: Discriminate, motion: Motion, pair: Pair) -> int | None:
    """Runs of the motion, in powers of two, that make the choice sure."""
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


def _most(goal: Discriminate, order: Pair, limits: Limits, rows: float) -> float:
    """Upper bound of the separation that so many rows of any motion can reach."""
    true, rival = (goal.hypotheses[place] for place in order)
    earlier = float(goal.earlier[order])
    bounds = most_informative(true, rival, goal.observation, limits, rows, separation_for(SURE) - earlier)
    return earlier + bounds[1]


def sentences(distinctions: Sequence[Distinction]) -> list[str]:
    """The same for a person, one paragraph a pair."""
    return [_sentence(one) for one in distinctions]


def _sentence(one: Distinction) -> str:
    text = (
        f"{one.pair[0]} or {one.pair[1]}: the probability of choosing right is "
        f"{percent(one.probability_before, 3)} before the run and {percent(one.probability_after, 3)} after."
    )
    if one.probability_after >= SURE:
        return text
    if not one.possible:
        text += (
            " No motion distinguishes them: an hour at the most informative states within the limits "
            f"leaves it at {percent(one.probability_hour, 3)} at most."
        )
    elif one.runs is not None:
        text += f" About {one.runs} such runs distinguish them."
    else:
        text += f" More than {MOST_RUNS} such runs would be needed."
    helping = [f"{o.name} ({percent(o.probability, 3)})" for o in one.remedies if o.probability >= SURE]
    others = [f"{o.name} ({percent(o.probability, 3)})" for o in one.remedies if o.probability < SURE]
    if helping:
        text += f" What would: the same run once more, with {' or '.join(helping)}."
    if others:
        text += f" What would not: {', '.join(others)}."
    return text
