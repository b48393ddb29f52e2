"""Limits of a plan for a robot: a plan's file narrows the robot's limits and never widens them."""

from dataclasses import fields, replace

import numpy as np

from exidyn.identification.arm.robot import Limits, Robot

from ..errors import BadLimits
from ..limits.usable_limits import require_movable
from .plan import Plan, differing_limits, robot_hash

SOME = 3
"""Maximum number of limits named in a sentence; a file with all limits changed would name 48."""
EDITED = "the plan's file has no checksum: it was written or edited by hand"
CHECKED_ANEW = (
    "Its limits, stops and torque are checked again, and collisions if the robot's geometry is known; its "
    "margins and criterion are not"
)
NAME_ROBOT = "Percentages refer to the limits in the file; use --robot to refer to those of the robot"


def tightest(first: Limits, second: Limits) -> Limits:
    """The narrower of two limits for each joint and side."""
    return Limits(
        **{
            f.name: (np.maximum if f.name.endswith("_lower") else np.minimum)(
                getattr(first, f.name), getattr(second, f.name)
            )
            for f in fields(Limits)
        }
    )


def within(plan: Plan, robot: Robot) -> Plan:
    """The plan with its limits restricted to those of a robot with the same joints.

    Raises:
        BadLimits: The position limits of plan and robot do not overlap.
    """
    limits = tightest(plan.limits, robot.limits)
    try:
        require_movable(limits)
    except BadLimits as error:
        raise BadLimits(f"limits of {robot.name} combined with those in the plan's file: {error}") from error
    return replace(plan, limits=limits)


def file_warnings(plan: Plan, robot: Robot | None = None) -> list[str]:
    """Warnings on the file of a plan, before `within`, for an operator; none if exidyn wrote it."""
    warnings = [f"{EDITED}. {CHECKED_ANEW if robot else NAME_ROBOT}"] if plan.edited else []
    if robot is None:
        return warnings
    if wider := _differences(plan, robot, wider=True):
        warnings.append(
            f"limits in the plan's file exceed those of {robot.name}, which are used: {some(wider)}"
        )
    if narrower := narrowed(plan, robot):
        warnings.append(
            f"limits in the plan's file are narrower than those of {robot.name}, and are used: "
            f"{some(narrower)}"
        )
    return warnings


def narrowed(plan: Plan, robot: Robot) -> list[str]:
    """Descriptions of limits in the plan's file that are narrower than those of its robot."""
    return _differences(plan, robot, wider=False)


def _differences(plan: Plan, robot: Robot, wider: bool) -> list[str]:
    """Descriptions of limits in the plan's file that are wider, or narrower, than the robot's.

    The result is empty for another robot than the one planned for, for which `robot_differences` names them.
    """
    if plan.robot_hash != robot_hash(robot):
        return []
    return [
        f"{name} of {joint} ({planned:g}, robot {current:g})"
        for name, joint, planned, current in differing_limits(plan, robot)
        if (planned < current if name.endswith("_lower") else planned > current) == wider
    ]


def some(sentences: list[str]) -> str:
    """The first sentences, and the number of further ones."""
    more = len(sentences) - SOME
    return "; ".join(sentences[:SOME]) + (f"; and {more} more" if more > 0 else "")
