"""A planned motion as a plain table, for JSON."""

from collections.abc import Sequence
from typing import Any

from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_use import Use
from exidyn.trajectories.trajectory import unit_of

from .json_output import plain


def plan_table(plan: Plan, uses: Sequence[Use], beyond: Sequence[str]) -> dict[str, Any]:
    """What was planned, how much of each limit it uses, and what is beyond; what is no number is None."""
    return plain(
        {
            "robot": plan.robot,
            "joints": list(plan.joints),
            "duration": plan.trajectory.duration,
            "tick": plan.tick,
            "payload_pair": plan.payload_pair,
            "criterion": plan.criterion or None,
            "reached": plan.reached,
            "details": dict(plan.details),
            "margins": dict(plan.margins),
            "seed": plan.seed,
            "robot_hash": plan.robot_hash,
            "model_hash": plan.model_hash,
            "use": {use.name: _use(use, plan.units) for use in uses},
            "beyond": list(beyond),
            "assumed": list(plan.assumed),
        }
    )


def _use(use: Use, units: Sequence[str]) -> dict[str, Any]:
    """Of each joint: what is reached, and the share of the limit, 1 at it, None where it has none."""
    return {
        "units": [unit_of(use.name, unit) for unit in units],
        "lower": use.reached.lower,
        "upper": use.reached.upper,
        "share": abs(use.share),
    }
