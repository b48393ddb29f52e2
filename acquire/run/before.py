"""Before: checks of a run without moving anything, and what forbids it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exidyn.identify.arm.robot import Limits, Robot
from exidyn.identify.model import Model
from exidyn.identify.recordings.recording import KnownPayload
from exidyn.trajectories.families.sequence import Slowed
from exidyn.trajectories.limits.usable_limits import Margins, usable
from exidyn.trajectories.plans.plan import Plan, model_differences, robot_differences
from exidyn.trajectories.plans.plan_check import Torque, nominal_torque, violations
from exidyn.trajectories.trajectory import Trajectory

from .arms import with_body
from .errors import NotAllowed

NO_MARGIN = Margins(position=0.0, slide=0.0, velocity=0.0, acceleration=0.0, jerk=0.0, torque=0.0)
RATES = ("velocity", "velocity_lower", "acceleration", "acceleration_lower", "jerk")


@dataclass(frozen=True)
class Checked:
    """A plan that this robot may run.

    Attributes:
        plan: At the speed at which it is to be played.
        model: Of the robot, with what it carries.
        limits: The robot's; those that are not given as the planner assumes them, or as the motion uses them.
        torque: Torque of the motion by the nominal model.
        warnings: What may be different than when it was planned, a sentence each.
    """

    plan: Plan
    model: Model
    limits: Limits
    torque: Torque
    warnings: tuple[str, ...]


def checked(plan: Plan, model: Model, speed: float = 1.0, payload: KnownPayload | None = None) -> Checked:
    """The plan at a share of its speed, if the robot may run it.

    Args:
        plan: What is to be run.
        model: Of the robot at hand.
        speed: Share of the planned speed [-].
        payload: What the robot carries.

    Raises:
        NotAllowed: It is for another robot, or goes beyond the limits of this one.
    """
    different = robot_differences(plan, model.robot)
    if different:
        raise NotAllowed(
            f"{model.robot.name} must not run a plan for {plan.robot}: {_some(different)}. Plan it again"
        )
    slowed = plan if speed == 1.0 else replace(plan, trajectory=Slowed(plan.trajectory, speed))
    # A pair is run twice, each run by itself; the torque of this run is that with its own payload.
    single = replace(slowed, payload_pair=bool(payload))
    carrying = with_body(model, payload)
    torque = nominal_torque(single, carrying)
    beyond = violations(single, torque)
    if beyond:
        raise NotAllowed(
            f"the plan goes beyond the limits of {model.robot.name}: {_some(beyond)}. Plan it again, or "
            "play it slower (exidyn record --speed)"
        )
    limits = _finite(model.robot, slowed.trajectory)
    return Checked(slowed, carrying, limits, torque, tuple(model_differences(plan, model)))


SOME = 3
"""Sentences that are enough to see what is wrong."""


def _some(sentences: Sequence[str]) -> str:
    more = len(sentences) - SOME
    return "; ".join(sentences[:SOME]) + (f"; and {more} more" if more > 0 else "")


def _finite(robot: Robot, motion: Trajectory) -> Limits:
    """The robot's limits; those not given as assumed, but no less than what the motion uses."""
    given, assumed = robot.limits, usable(robot, NO_MARGIN).limits
    extremes = motion.extremes()
    found: dict[str, np.ndarray] = {}
    for name in RATES:
        used = getattr(extremes, name.removesuffix("_lower"))
        if name.endswith("_lower"):
            needed = np.minimum(getattr(assumed, name), used.lower)
        else:
            needed = np.maximum(
                getattr(assumed, name), np.maximum(used.upper, -used.lower * (name == "jerk"))
            )
        found[name] = np.where(np.isfinite(getattr(given, name)), getattr(given, name), needed)
    return replace(given, **found)
