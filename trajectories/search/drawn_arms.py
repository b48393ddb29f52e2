"""Arms drawn within what is known of one: how many pass a torque limit, and how wide a band must be for few.

The band that holds the whole torque of a share of arms is wider than limits need: a motion is near a limit of
some joints at some times only. So a motion has a factor of its own, by which arms pass limits that it comes
as near to with its band as it does to the limits there are.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..trajectory import States
from .goals import Goal
from .torque_bound import TorqueBound
from .torque_spread import TorqueSpread

AIM = 0.5
"""Share of the arms that may pass a limit for which a factor is made: the motion changes after it, and the
draws have their scatter."""
STEPS = 20
"""Bisections: a millionth of the widest factor."""


def peaks(goal: Goal, states: States) -> np.ndarray:
    """Largest torque of each drawn arm and joint in all runs of a motion, shape (k, n) [N m]."""
    assert goal.spread is not None
    bound = TorqueBound(goal.model, np.full(goal.model.robot.dof, np.inf), goal.payloads)
    found = [
        goal.spread.peaks(goal.model, states.motion(payload), bound.torque(states, payload))
        for payload in goal.payloads
    ]
    return np.asarray(np.max(found, axis=0))


def share_beyond(goal: Goal, states: States, limit: np.ndarray) -> float:
    """Share of drawn arms that pass a torque limit (n,) at some sample of some run, whatever the joint."""
    if goal.spread is None:
        return 0.0
    return goal.spread.share_beyond(peaks(goal, states), limit)


def with_own_factor(goal: Goal, states: States, limit: np.ndarray) -> Goal:
    """The goal with the factor that this motion needs, as near to the limits (n,) as it is with its own now.

    Where it passes them with the present factor, it counts as one that is just inside.
    """
    spread = goal.spread
    if spread is None or spread.widest == 0.0:
        return goal
    drawn, reach = peaks(goal, states), _reach(goal, spread, states)
    slack = np.maximum(limit / reach(spread.factor), 1.0)

    def enough(factor: float) -> bool:
        beyond = replace(spread, factor=factor).share_beyond(drawn, slack * reach(factor))
        return beyond <= AIM * (1.0 - spread.share)

    low, high = 0.0, spread.widest
    if enough(low):  # a motion far from torque limits: then the band costs a search nothing
        return goal.with_spread(replace(spread, factor=low))
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if enough(middle) else (middle, high)
    return goal.with_spread(replace(spread, factor=high))


def _reach(goal: Goal, spread: TorqueSpread, states: States) -> Callable[[float], np.ndarray]:
    """Farthest end of the band of each joint in all runs, shape (n,) [N m], as a function of its factor."""
    one = replace(spread, factor=1.0)
    bound = TorqueBound(goal.model, np.full(goal.model.robot.dof, np.inf), goal.payloads, one)
    torque = np.abs(np.concatenate([bound.torque(states, payload) for payload in goal.payloads]))
    deviation = np.concatenate([bound.band(states, payload) for payload in goal.payloads])
    return lambda factor: np.max(torque + factor * deviation, axis=0)
