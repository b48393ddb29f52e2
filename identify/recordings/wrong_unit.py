"""What unit numbers seem to be in that no joint can have in radians."""

import re

import numpy as np

from ..arm.robot import Robot
from .restored_columns import lost_sign

PERCENT = 100.0
"""Opening of a gripper that is all of it."""
GRIPPERS = re.compile(r"gripper|finger|jaw|claw|hand(?!le)", re.IGNORECASE)
"""Names of what opens and closes, for which controllers give a share."""
TURNS = 720.0
"""Degrees that a joint of an arm never reaches: two turns."""
IN_RADIANS = 4 * np.pi
"""What the other joints keep within where they are in radians."""

WHOLE = 1e-6
"""How far a number may be from a whole one, after a conversion."""
PER_CENT = (
    "this looks like per cent of what a gripper opens. Give it in radians, or leave the joint out: "
    "joints = [...] in robot.toml"
)
OF_STEPS = "subtract that of zero, and multiply by 2 pi over the steps a turn (often 4096)"
OF_STEPS_SIGNED = "subtract that of zero, and multiply by 2 pi over the steps a turn if they are steps"
MILLIMETRES = "It looks like millimetres: import with positions in metres"


def in_percent(joint: str, values: np.ndarray) -> bool:
    """Whether numbers (t,) are rather a share of what a gripper opens; the name decides."""
    known = values[np.isfinite(values)]
    share = len(known) > 0 and float(known.min()) >= 0.0 and IN_RADIANS < float(known.max()) <= PERCENT
    return share and GRIPPERS.search(joint) is not None


def percent_questions(robot: Robot, position: np.ndarray) -> list[str]:
    """What is asked about grippers whose positions, shape (t, n) [rad], were given in degrees."""
    return [
        f"{joint} goes from {np.nanmin(degrees):.4g} to {np.nanmax(degrees):.4g}, read in degrees: is it per "
        "cent of what it opens? Then its unit is 0-100% (--units position=deg,...,0-100%), or leave the "
        "joint out: joints = [...] in robot.toml"
        for joint, degrees in zip(robot.joints, np.degrees(position.T), strict=True)
        if in_percent(joint, degrees)
    ]


def unit_questions(robot: Robot, values: np.ndarray, unit: str) -> list[str]:
    """What is asked about positions of a log, shape (t, n), that are taken for those of a unit.

    Args:
        robot: The arm.
        values: As the log has them.
        unit: "rad", "deg" or one of length.
    """
    turning = [(robot.joints[j], values[:, j]) for j in np.flatnonzero(robot.revolute)]
    signs = {joint: lost.fact for joint, column in turning if (lost := lost_sign(column)) is not None}
    if signs:
        return [f"{joint}: {sign_advice(how)}" for joint, how in signs.items()]
    ticks = [joint for joint, column in turning if in_ticks(column)]
    if ticks:
        joint, column = next(one for one in turning if one[0] in ticks)
        return [f"{', '.join(ticks)}: {angle_advice(joint, column, values.T[:0])}"]
    if unit == "deg":
        return percent_questions(robot, np.radians(values))
    return [
        f"{joint} goes up to {np.nanmax(column):.4g}: {PER_CENT}"
        for joint, column in turning
        if unit == "rad" and in_percent(joint, column)
    ]


def sign_advice(how: str) -> str:
    """What to do about positions that were read from a register without their sign; `how` they were."""
    return f"The positions look like a register read {how}. Restore the sign, {OF_STEPS_SIGNED}, and import"


def in_ticks(values: np.ndarray) -> bool:
    """Whether numbers (t,) are steps of an encoder: whole, and too many for degrees."""
    known = values[np.isfinite(values)]
    whole = len(known) > 0 and bool(np.all(np.abs(known - np.round(known)) < WHOLE))
    return whole and float(np.abs(known).max()) > TURNS


def angle_advice(joint: str, values: np.ndarray, others: np.ndarray) -> str:
    """What to do about angles (t,) that a joint cannot have in radians.

    Args:
        joint: Name of the joint.
        values: Its positions.
        others: Positions of the other joints that turn, shape (n - 1, t).
    """
    if (lost := lost_sign(values)) is not None:
        return sign_advice(lost.fact)
    # They may have been taken for degrees already.
    ticks = next((one for one in (values, np.degrees(values)) if in_ticks(one)), None)
    if ticks is not None:
        return (
            f"Whole numbers, {np.nanmin(ticks):.0f} to {np.nanmax(ticks):.0f}, look like steps of an "
            f"encoder: {OF_STEPS}"
        )
    if np.nanmax(np.abs(values)) > TURNS:
        return f"In degrees it were impossible, too. As counts of an encoder: {OF_STEPS}"
    if in_percent(joint, values) and np.all(np.abs(others) < IN_RADIANS):
        return f"The other joints are in radians: {PER_CENT}"
    degrees = "It looks like degrees: import with degrees=True (--degrees)"
    beyond = np.nanmax(np.abs(values)) > PERCENT
    return degrees if beyond else f"{degrees}; per cent of a joint's travel is --units position=%"
