"""Most informative states: how far any motion could separate two hypotheses, whatever joins its states."""

import numpy as np

from exidyn.identify.arm.motion import Motion
from exidyn.identify.arm.robot import Limits

from .hypothesis import Hypothesis
from .separation import Observation, explain

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
