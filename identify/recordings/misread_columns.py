"""Columns whose numbers are not what they seem: turns or a sign were lost, or the unit is another.

Lost turns and signs need no model: a joint does not turn by 360 degrees between two samples, and an effort
does not jump from one end of a 16-bit register to the other.
"""

import re
from typing import NamedTuple

import numpy as np

from ..arm.robot import Robot

NEAR = 0.1
"""Maximum difference between a jump and a full turn, in turns: a joint moves less between two samples."""
WIDTHS = (8, 16, 32)
"""Widths of registers in bits."""
SIGN_BITS = tuple(range(9, 16))
"""Bits that servos use for the sign of a magnitude; Feetech and Dynamixel (protocol 1) use the tenth."""
SMOOTHER = 4.0
"""Minimum factor by which the largest step between samples shrinks when a lost sign is restored: a signal
that jumped across its range then passes through zero."""
WRITTEN = 5e-6
"""Relative error of a count of a register in a log: half of the sixth digit or better."""
HALF = 0.5
"""Distance from a whole count from which a value is not a count: large counts are written with few digits."""
FEWEST = 40
"""Minimum number of samples to detect a lost sign."""


class Restored(NamedTuple):
    """A restored column."""

    values: np.ndarray  # restored values, shape (t,)
    fact: str  # description of the loss and its restoration
    turn: float = 0.0  # difference by which values without a sign are too large; 0 if it is not constant


def unwrapped(position: np.ndarray, turn: float = 2 * np.pi) -> Restored | None:
    """Positions (t,) without jumps by a full turn; None if there are no such jumps."""
    known = np.isfinite(position)
    steps = np.diff(position[known])
    jumps = int(np.sum(np.abs(np.abs(steps) - turn) < NEAR * turn))
    other = np.abs(steps)[np.abs(steps) < turn * (1 - NEAR)]
    # Jumps of different sizes are noise or another unit; jumps of one size are turns.
    if not jumps or np.max(other, initial=0.0) > 0.5 * turn:
        return None
    values = np.array(position)
    values[known] = np.unwrap(position[known], period=turn)
    return Restored(values, f"jumped by a full turn {jumps} times; the turns are undone")


def signed(effort: np.ndarray) -> Restored | None:
    """Efforts (t,) whose sign was lost when a register was read; None if it was not lost."""
    lost = lost_sign(effort)
    if lost is None:
        return None
    return lost._replace(fact=f"was read {lost.fact}; the sign is restored")


def signed_like(effort: np.ndarray, turn: float) -> Restored | None:
    """Efforts (t,) that are always negative, so that only other joints show that their sign was lost."""
    known = effort[np.isfinite(effort)]
    if not turn or not len(known) or known.min() < 0.5 * turn or known.max() >= turn * (1.0 + WRITTEN):
        return None
    fact = f"is above {0.5 * turn:.6g} throughout: its sign is lost as that of other joints, and restored"
    return Restored(effort - turn, fact, turn)


def lost_sign(effort: np.ndarray) -> Restored | None:
    """Values (t,) of a register with restored sign, and how they were read; None if the sign was not lost.

    A number of k bits was read as unsigned (-45 becomes 65491), or one of its bits is the sign (-45 becomes
    1069). The values may have any unit: their step is one count of the register.
    """
    known = effort[np.isfinite(effort)]
    step = _count(known)
    if len(known) < FEWEST or step is None or known.min() < 0.0:
        return None
    counts = np.round(effort / step)
    largest = counts[np.isfinite(counts)].max()
    readings = {
        (f"as {bits} bits without a sign: -45 is {2**bits - 45}", 2.0**bits): np.where(
            counts >= 2 ** (bits - 1), counts - 2.0**bits, counts
        )
        for bits in WIDTHS
        if 2 ** (bits - 1) <= largest < 2**bits
    }
    readings |= {
        (f"with its sign, bit {bit}, as part of the number: -45 is {2**bit + 45}", 0.0): np.where(
            counts >= 2**bit, 2.0**bit - counts, counts
        )
        for bit in SIGN_BITS
        if 2**bit < largest < 2 ** (bit + 1)
    }
    if not readings:
        return None
    name, turn = min(readings, key=lambda reading: _roughness(readings[reading]))
    if _roughness(readings[name, turn]) * SMOOTHER > _roughness(counts):
        return None
    return Restored(readings[name, turn] * step, name, turn * step)


def _count(values: np.ndarray) -> float | None:
    """Count of a register: the step of which all values (t,) are multiples; None if there is none."""
    sizes = np.unique(np.abs(values))
    sizes = sizes[sizes > 0]
    if len(sizes) < 3:
        return None
    # Large counts may be written with too few digits to show the step.
    small = sizes[sizes < 0.5 * sizes[-1]] if sizes[0] < 0.25 * sizes[-1] else sizes
    steps = np.diff(small) if len(small) > 3 else np.diff(sizes)
    for step in (1.0, float(np.median(steps[steps < 1.5 * np.percentile(steps, 5)])), float(sizes[0])):
        with np.errstate(over="ignore"):
            multiples = sizes / step
        clear = WRITTEN * multiples < HALF
        if not np.isfinite(multiples).all() or not clear.any():
            continue
        off = np.abs(multiples - np.round(multiples))
        counts = np.round(multiples[clear])
        if counts.any() and np.all(off < 0.01 + WRITTEN * multiples):
            return float(sizes[clear] @ counts / (counts @ counts)) if step != 1.0 else step
    return None


def _roughness(values: np.ndarray) -> float:
    """Largest step between neighboring samples."""
    return float(np.max(np.abs(np.diff(values[np.isfinite(values)]))))


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
