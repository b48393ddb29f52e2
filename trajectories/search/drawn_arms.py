"""Sampled arms: how many exceed a torque limit, and how wide a torque band must be for few to exceed it.

The band that contains the entire torque of a share of arms is wider than necessary: a motion is near a limit
for some joints at some times only. So each motion gets its own factor, with which few arms exceed limits that
the band is as close to as it is to the actual limits.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..trajectory import States
from .goals import Goal
from .torque_bound import TorqueBound
from .torque_spread import TorqueSpread

AIM = 0.5
"""Share of the admissible violations for which a factor is chosen: the motion changes afterwards, and the
samples scatter."""
STEPS = 20
"""Number of bisections: a resolution of a millionth of the widest factor."""


def peaks(goal: Goal, states: States) -> np.ndarray:
    """Largest torque of each sampled arm and joint in all runs of a motion, shape (k, n) [N m]."""
    assert goal.spread is not None
    bound = TorqueBound(goal.model, np.full(goal.model.robot.dof, np.inf), goal.payloads)
    run_peaks = [
        goal.spread.peaks(goal.model, states.motion(payload), bound.torque(states, payload))
        for payload in goal.payloads
    ]
    return np.asarray(np.max(run_peaks, axis=0))


def share_beyond(goal: Goal, states: States, limit: np.ndarray) -> float:
    """Share of sampled arms that exceed a torque limit, shape (n,), in any joint, sample and run."""
    if goal.spread is None:
        return 0.0
    return goal.spread.share_beyond(peaks(goal, states), limit)


def with_own_factor(goal: Goal, states: States, limit: np.ndarray) -> Goal:
    """The goal with the band factor that this motion needs at its present distance to the limits, shape (n,).

    A motion that exceeds the limits with the present factor is treated as one that just keeps to them.
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
    if enough(low):  # the motion is far from torque limits, so the band does not restrict a search
        return goal.with_spread(replace(spread, factor=low))
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if enough(middle) else (middle, high)
    return goal.with_spread(replace(spread, factor=high))


def _reach(goal: Goal, spread: TorqueSpread, states: States) -> Callable[[float], np.ndarray]:
    """Function from factor to largest absolute torque in the band of each joint, shape (n,) [N m]."""
    unit_spread = replace(spread, factor=1.0)
    bound = TorqueBound(goal.model, np.full(goal.model.robot.dof, np.inf), goal.payloads, unit_spread)
    torque = np.abs(np.concatenate([bound.torque(states, payload) for payload in goal.payloads]))
    deviation = np.concatenate([bound.band(states, payload) for payload in goal.payloads])
    return lambda factor: np.max(torque + factor * deviation, axis=0)
