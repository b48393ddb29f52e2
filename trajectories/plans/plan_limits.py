"""Limits of a plan for the robot at hand: a plan's file narrows the robot's limits and never widens them."""

from dataclasses import fields, replace

import numpy as np

from exidyn.identification.arm.robot import Limits, Robot

from ..errors import BadLimits
from ..limits.usable_limits import require_movable
from .plan import Plan, robot_hash

SOME = 3
"""Limits named one by one in a sentence; a file whose limits were all multiplied would name 48."""
EDITED = "the plan's file has no checksum: it was written or edited by hand"
CHECKED_ANEW = (
    "Its limits, stops and torque are checked again, and collisions where the robot's geometry is known; its "
    "margins and criterion are not"
)
NAME_ROBOT = "Percentages are of the limits in the file; --robot gives those of the robot"


def tightest(first: Limits, second: Limits) -> Limits:
    """The narrower of two limits, for each joint and each side."""
    return Limits(
        **{
            f.name: (np.maximum if f.name.endswith("_lower") else np.minimum)(
                getattr(first, f.name), getattr(second, f.name)
            )
            for f in fields(Limits)
        }
    )


def within(plan: Plan, robot: Robot) -> Plan:
    """The plan with its limits cut to those of the robot at hand, which has the same joints.

    Raises:
        BadLimits: The position limits of the two have nothing in common.
    """
    limits = tightest(plan.limits, robot.limits)
    try:
        require_movable(limits)
    except BadLimits as error:
        raise BadLimits(f"limits of {robot.name} together with those in the plan's file: {error}") from error
    return replace(plan, limits=limits)


def file_warnings(plan: Plan, robot: Robot | None = None) -> list[str]:
    """What an operator should know of the plan's file, a sentence each; none where exidyn wrote it.

    Args:
        plan: As it was read, before `within`.
        robot: The robot at hand, with the same joints, if there is one.
    """
    warnings = [f"{EDITED}. {CHECKED_ANEW if robot else NAME_ROBOT}"] if plan.edited else []
    if robot is None:
        return warnings
    if wider := _differences(plan, robot, plan.limits):
        warnings.append(f"limits in the plan's file exceed those of {robot.name}, which count: {some(wider)}")
    if narrower := narrowed(plan, robot):
        warnings.append(
            f"limits in the plan's file are narrower than those of {robot.name}, and count: {some(narrower)}"
        )
    return warnings


def narrowed(plan: Plan, robot: Robot) -> list[str]:
    """Limits in the plan's file that are narrower than those of the robot it was planned for, in words."""
    return _differences(plan, robot, robot.limits)


def _differences(plan: Plan, robot: Robot, limits: Limits) -> list[str]:
    """Limits that are wider than the narrower of plan and robot, with the values of file and robot.

    Where the robot is another than the one planned for, `robot_differences` names the limits.
    """
    if plan.robot_hash != robot_hash(robot):
        return []
    narrow = tightest(plan.limits, robot.limits)
    sentences = []
    for name in (f.name for f in fields(Limits)):
        planned, here = getattr(plan.limits, name), getattr(robot.limits, name)
        for joint in np.flatnonzero(getattr(limits, name) != getattr(narrow, name)):
            values = f"{planned[joint]:g}, robot {here[joint]:g}"
            sentences.append(f"{name} of {robot.joints[joint]} ({values})")
    return sentences


def some(sentences: list[str]) -> str:
    """The first sentences, and how many there are beside them."""
    more = len(sentences) - SOME
    return "; ".join(sentences[:SOME]) + (f"; and {more} more" if more > 0 else "")
