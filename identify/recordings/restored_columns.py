"""Columns whose numbers lost a turn or a sign on their way into a log, and how they are restored.

No model is asked: a joint does not turn by 360 degrees between two samples, and an effort does not jump from
one end of a 16-bit register to the other.
"""

from typing import NamedTuple

import numpy as np

NEAR = 0.1
"""Share of a turn by which a jump may miss a full one: a joint moves less than that between two samples."""
WIDTHS = (8, 16, 32)
"""Bits of registers."""
SIGN_BITS = tuple(range(9, 16))
"""Bits that servos use for the sign of a size; Feetech and Dynamixel (protocol 1) have the tenth."""
SMOOTHER = 4.0
"""Factor by which the largest step between samples shrinks when a lost sign is restored: a signal that jumps
across its range becomes one that passes through zero."""
WRITTEN = 1e-8
"""Relative error of a count of a register as logs are written: half of the ninth digit or better."""
FEWEST = 40
"""Samples in which a lost sign can be seen."""


class Restored(NamedTuple):
    """A column as it was measured.

    Attributes:
        values: Shape (t,).
        fact: What was done, and in how many samples.
    """

    values: np.ndarray
    fact: str


def unwrapped(position: np.ndarray, turn: float = 2 * np.pi) -> Restored | None:
    """Positions (t,) without jumps by a full turn; None where there is none."""
    known = np.isfinite(position)
    steps = np.diff(position[known])
    jumps = int(np.sum(np.abs(np.abs(steps) - turn) < NEAR * turn))
    other = np.abs(steps)[np.abs(steps) < turn * (1 - NEAR)]
    # Jumps of all sizes are noise, or another unit; those of one size are turns.
    if not jumps or np.max(other, initial=0.0) > 0.5 * turn:
        return None
    values = np.array(position)
    values[known] = np.unwrap(position[known], period=turn)
    return Restored(values, f"jumped by a full turn {jumps} times; the turns are undone")


def signed(effort: np.ndarray) -> Restored | None:
    """Efforts (t,) whose sign was lost when a register was read; None where none was lost."""
    lost = lost_sign(effort)
    if lost is None:
        return None
    changed = int(np.sum(lost.values < 0))
    return lost._replace(
        fact=f"was read {lost.fact}; the sign is restored in {changed} of {len(effort)} samples"
    )


def lost_sign(effort: np.ndarray) -> Restored | None:
    """Values (t,) of a register with their sign, and how they were read without it; None if none was lost.

    A number of k bits was read as one without sign (-45 becomes 65491), or one bit of it is the sign
    (-45 becomes 1069). Its unit may be any: one step of it is one count of the register.
    """
    known = effort[np.isfinite(effort)]
    step = _count(known)
    if len(known) < FEWEST or step is None or known.min() < 0.0:
        return None
    counts = np.round(effort / step)
    largest = counts[np.isfinite(counts)].max()
    readings = {
        f"as {bits} bits without a sign: {_example(2**bits)}": np.where(
            counts >= 2 ** (bits - 1), counts - 2.0**bits, counts
        )
        for bits in WIDTHS
        if 2 ** (bits - 1) <= largest < 2**bits
    }
    readings |= {
        f"with its sign, bit {bit}, as part of the number: -45 is {2**bit + 45}": np.where(
            counts >= 2**bit, 2.0**bit - counts, counts
        )
        for bit in SIGN_BITS
        if 2**bit < largest < 2 ** (bit + 1)
    }
    if not readings:
        return None
    name = min(readings, key=lambda one: _roughness(readings[one]))
    if _roughness(readings[name]) * SMOOTHER > _roughness(counts):
        return None
    return Restored(readings[name] * step, name)


def _example(turn: int) -> str:
    return f"-45 is {turn - 45}"


def _count(values: np.ndarray) -> float | None:
    """One count of a register, of which all values (t,) are whole multiples; None if there is none."""
    sizes = np.unique(np.abs(values))
    sizes = sizes[sizes > 0]
    if len(sizes) < 3:
        return None
    steps = np.diff(sizes)
    for step in (1.0, float(np.median(steps[steps < 1.5 * np.percentile(steps, 5)])), float(sizes[0])):
        with np.errstate(over="ignore"):
            multiples = sizes / step
        whole = np.isfinite(multiples).all()
        if whole and np.all(np.abs(multiples - np.round(multiples)) < 0.01 + WRITTEN * multiples):
            return step
    return None


def _roughness(values: np.ndarray) -> float:
    """The largest step between neighbouring samples."""
    return float(np.max(np.abs(np.diff(values[np.isfinite(values)]))))
