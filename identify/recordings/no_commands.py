"""Detection of columns that are not commands: copies of positions, even of later samples, or their steps."""

import numpy as np

LATEST = 10
"""Maximum shift of copied positions in samples."""
EXACT = 1e-5
"""Maximum difference from a copy, over a joint's range, due to rounding. No servo meets every command."""
ALMOST = 0.98
"""Minimum share of the samples in motion that match in a copy; a run may end with a repeated sample."""
FEWEST = 20
"""Minimum number of samples in motion to detect a copy."""
FOLLOWS = 0.5
"""Correlation of commands and positions below which a joint does not follow."""
STEPS = 0.8
"""Correlation of commands with the steps of positions above which they are these steps."""
SMALL = 0.2
"""Ratio of the spread of commands to that of positions below which commands are not goals."""
CHANGING = 0.5
"""Share of the samples in which commands change above which they are a motion."""
PROPORTIONAL = 0.98
"""Correlation above which commands are the steps times a rate or unit: no lag of a joint is so exact."""
ALIKE = 3.0
"""Maximum ratio of commands to the steps that they are, or its inverse. A joint that lags by a quarter of a
period follows the derivative of the commands too, but its steps are far smaller."""
NO_EFFORT = "with no error of the servo there is no effort. Record the positions that the servos were sent"


def no_commands(command: np.ndarray, position: np.ndarray) -> str:
    """Why commands (t, n) for positions (t, n) in the same unit are not commands; empty if they may be.

    The sampling rate is constant, and joints at rest count as following.
    """
    if np.array_equal(command, position):
        return f"commands are the positions: {NO_EFFORT}"
    reach = np.ptp(position, axis=0)
    moving = np.flatnonzero(reach > 0.0)
    command, position, reach = command[:, moving], position[:, moving], reach[moving]
    if not len(moving) or len(position) < 2 * LATEST:
        return ""
    moved = np.abs(np.diff(position, axis=0)) > EXACT * reach
    for shift in range(LATEST + 1):
        later = position[shift:]
        exact = np.abs(command[: len(later)] - later) <= EXACT * reach
        in_motion = moved[: len(later)]
        if in_motion.sum() >= FEWEST and np.mean(exact[: len(in_motion)][in_motion]) >= ALMOST:
            source = {0: "positions", 1: "positions of the next sample"}
            return f"commands are the {source.get(shift, f'positions {shift} samples later')}: {NO_EFFORT}"
    if np.any(_correlation(command, position) > FOLLOWS):
        return ""
    # Commands that are mostly constant may hold a falling joint.
    changing = np.mean(np.any(np.diff(command, axis=0) != 0.0, axis=1)) > CHANGING
    if changing and np.median(command.std(axis=0) / position.std(axis=0)) < SMALL:
        return (
            "commands do not follow the positions, and move far less: they look like steps, or like goals "
            "relative to the position. If so, add to each the position from which it starts"
        )
    steps = np.diff(position, axis=0)
    alike = max(float(np.median(_correlation(command[k : len(steps) + k], steps))) for k in (0, 1))
    larger = float(np.median(command.std(axis=0) / np.maximum(steps.std(axis=0), 1e-300)))
    if alike > PROPORTIONAL or (alike > STEPS and 1 / ALIKE < larger < ALIKE):
        return (
            "commands do not follow the positions: they look like steps to the next position. If these were "
            "the goals of the servos, add to each the position from which it starts"
        )
    return ""


def _correlation(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Correlation of columns (t, n), shape (n,); zero if a column is constant."""
    first, second = first - first.mean(axis=0), second - second.mean(axis=0)
    size = np.linalg.norm(first, axis=0) * np.linalg.norm(second, axis=0)
    return np.asarray(np.sum(first * second, axis=0) / np.where(size > 0.0, size, 1.0))
