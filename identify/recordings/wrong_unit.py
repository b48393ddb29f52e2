"""Likely units of numbers that are impossible as joint positions in radians."""

import re

import numpy as np

from ..arm.robot import Robot
from .restored_columns import lost_sign

PERCENT = 100.0
"""Value of a fully open gripper [%]."""
GRIPPERS = re.compile(r"gripper|finger|jaw|claw|hand(?!le)", re.IGNORECASE)
"""Names of joints that open and close, for which controllers report a percentage."""
TURNS = 720.0
"""Maximum position of an arm's joint [deg]: two turns."""
IN_RADIANS = 4 * np.pi
"""Maximum position of the other joints if they are in radians [rad]."""

WHOLE = 1e-6
"""Maximum distance of a number from a whole number, after a conversion."""
PER_CENT = (
    "this looks like per cent of what a gripper opens. Give it in radians, or leave the joint out: "
    "joints = [...] in robot.toml"
)
OF_STEPS = "subtract that of zero, and multiply by 2 pi over the steps a turn (often 4096)"
OF_STEPS_SIGNED = "subtract that of zero, and multiply by 2 pi over the steps a turn if they are steps"


def in_percent(joint: str, values: np.ndarray) -> bool:
    """Whether numbers (t,) are likely percentages of a gripper's opening, judged by the name of the joint."""
    known = values[np.isfinite(values)]
    share = len(known) > 0 and float(known.min()) >= 0.0 and IN_RADIANS < float(known.max()) <= PERCENT
    return share and GRIPPERS.search(joint) is not None


def percent_questions(robot: Robot, position: np.ndarray) -> list[str]:
    """Questions about grippers whose positions, shape (t, n) [rad], were converted from degrees."""
    return [
        f"{joint} goes from {np.nanmin(degrees):.4g} to {np.nanmax(degrees):.4g}, read in degrees: is it per "
        "cent of what it opens? Then its unit is 0-100% (exidyn import --units position=deg,...,0-100%), or "
        "leave the joint out: joints = [...] in robot.toml"
        for joint, degrees in zip(robot.joints, np.degrees(position.T), strict=True)
        if in_percent(joint, degrees)
    ]


def unit_questions(robot: Robot, values: np.ndarray, unit: str) -> list[str]:
    """Questions about positions (t, n) of a log with an assumed unit: "rad", "deg" or a unit of length."""
    turning = [(robot.joints[j], values[:, j]) for j in np.flatnonzero(robot.revolute)]
    signs = {joint: lost.fact for joint, column in turning if (lost := lost_sign(column)) is not None}
    if signs:
        return [f"{joint}: {sign_advice(how)}" for joint, how in signs.items()]
    ticks = [joint for joint, column in turning if in_ticks(column)]
    if ticks:
        joint, column = next(named for named in turning if named[0] in ticks)
        return [f"{', '.join(ticks)}: {angle_advice(joint, column, values.T[:0])}"]
    return [
        f"{joint} goes up to {np.nanmax(column):.4g}: {PER_CENT}"
        for joint, column in turning
        if unit == "rad" and in_percent(joint, column)
    ]


def sign_advice(how: str) -> str:
    """Advice about positions that were read from a register without their sign, in the way `how`."""
    return f"The positions look like a register read {how}. Restore the sign, {OF_STEPS_SIGNED}, and import"


def in_ticks(values: np.ndarray) -> bool:
    """Whether numbers (t,) are steps of an encoder: whole, and too many for degrees."""
    known = values[np.isfinite(values)]
    is_whole = len(known) > 0 and bool(np.all(np.abs(known - np.round(known)) < WHOLE))
    return is_whole and float(np.abs(known).max()) > TURNS


def angle_advice(joint: str, values: np.ndarray, others: np.ndarray) -> str:
    """Advice about positions (t,) of a joint that are impossible in radians; empty if they may be in degrees.

    `others` are those of the other revolute joints, shape (n - 1, t).
    """
    if (lost := lost_sign(values)) is not None:
        return sign_advice(lost.fact)
    # They may have been converted from degrees already.
    ticks = next((angles for angles in (values, np.degrees(values)) if in_ticks(angles)), None)
    if ticks is not None:
        return (
            f"Whole numbers, {np.nanmin(ticks):.0f} to {np.nanmax(ticks):.0f}, look like steps of an "
            f"encoder: {OF_STEPS}"
        )
    if np.nanmax(np.abs(values)) > TURNS:
        return f"It is impossible in degrees too. If it is in counts of an encoder: {OF_STEPS}"
    if in_percent(joint, values) and np.all(np.abs(others) < IN_RADIANS):
        return f"The other joints are in radians: {PER_CENT}"
    return ""
