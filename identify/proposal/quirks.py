"""What else is seen in the samples: rate, gaps, and what encoders and recorders do."""

import numpy as np

from ..arm.robot import Robot
from ..notebook import counted
from ..text_table import digits
from .agreement import runs_of

GAP = 1.5
"""Steps of more median periods than this miss at least one sample."""
COARSE = 0.3
"""Share of equal neighbours from which on the resolution of an encoder is seen."""
REPEATED = 0.3
"""Share of samples in motion whose joints all repeat the one before, from which on it is said."""


def quirks(time: np.ndarray, position: np.ndarray, robot: Robot, rows: int) -> list[str]:
    """Sentences about the samples; time (t,) [s], position (t, n) [rad], `rows` of the file."""
    runs, steps = runs_of(time), np.diff(time)
    period = float(np.median(steps))
    steps = np.delete(steps, [run.stop - 1 for run in runs[:-1]])
    long = steps > GAP * period
    of = f" in {len(runs)} runs" if len(runs) > 1 else ""
    notes = [f"{len(time)} samples at {digits(1 / period)} Hz, {digits(steps.sum())} s{of}"]
    if rows > len(time):
        notes.append(f"{rows - len(time)} of {rows} rows lack a number, or repeat or go back in time")
    if long.any():
        notes.append(f"{counted(int(long.sum()), 'gap')}, the longest {digits(1e3 * steps.max())} ms")
    change = np.abs(np.diff(position, axis=0))
    moving = change.max(axis=1) > 0
    repeated = float(np.mean(~moving[np.argmax(moving) : len(moving) - np.argmax(moving[::-1])]))
    if moving.any() and repeated > REPEATED:
        notes.append(f"{100 * repeated:.0f} % of the samples repeat all positions of the one before")
    for joint, column in zip(robot.joints, change.T, strict=True):
        notes += _encoder(joint, column, robot.revolute[robot.index(joint)])
    beyond = np.maximum(
        robot.limits.position_lower - position.min(axis=0), position.max(axis=0) - robot.limits.position_upper
    )
    for j in np.flatnonzero(beyond > 0.1):
        notes.append(
            f"{robot.joints[j]} goes {digits(beyond[j])} beyond its limits: is its zero that of the URDF?"
        )
    return notes


def at_rest(joint: str) -> str:
    """Note about a joint that stands still."""
    return f"{joint} does not move"


def _encoder(joint: str, change: np.ndarray, revolute: bool) -> list[str]:
    """Notes about one joint, from the sizes of its steps, shape (t - 1,)."""
    moved = change[change > 1e-9]
    if not len(moved):
        return [at_rest(joint)]
    notes = []
    turns = np.sum(np.abs(change - 2 * np.pi) < 0.5) if revolute else 0
    if turns:
        notes.append(f"{joint} jumps by a full turn {turns} times: unwrap it before the import")
    if np.mean(change <= 1e-9) > COARSE and len(np.unique(np.round(moved / moved.min()))) < 50:
        unit = "rad" if revolute else "m"
        notes.append(f"{joint} is read in steps of {moved.min():.2g} {unit}")
    return notes
