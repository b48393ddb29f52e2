"""Jumps of a motion: samples that do not follow from the previous sample.

Pieces of a motion are stored with the state at which each begins, so a number changed by hand leaves a motion
that keeps every limit before and after a jump. Between two samples a time h apart, a motion without jumps
moves as its velocity and acceleration predict, within J h^3 / 6, where J is its largest jerk; velocity and
acceleration change accordingly.
"""

from collections.abc import Iterator

import numpy as np

from ..families.sequence import JOIN
from ..trajectory import Trajectory, unit_of
from .plan import Plan

JOINS = 4
"""Maximum number of joins of a sequence between two samples; each may be off by `JOIN`."""


def jumps(plan: Plan, spacing: float) -> list[str]:
    """Sentences on the largest jump of each joint in position, velocity and acceleration.

    Args:
        plan: The motion.
        spacing: Spacing of the samples [s].
    """
    sentences = []
    for name, size, time in _unexplained(plan.trajectory, spacing):
        for joint in np.flatnonzero(np.max(size, axis=0) > 0.0):
            row = int(np.argmax(size[:, joint]))
            sentences.append(
                f"{plan.joints[joint]}: {name} jumps by more than {size[row, joint]:.3g} "
                f"{unit_of(name, plan.units[joint])} at {time[row]:.3f} s"
            )
    return sentences


def _unexplained(trajectory: Trajectory, spacing: float) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Name of a quantity, its changes beyond what jerk explains, shape (t, n), and times, shape (t,) [s]."""
    time = trajectory.every(spacing).time
    states = trajectory.at(np.append(time, trajectory.duration))
    step = np.diff(states.time)[:, None]
    velocity, acceleration = states.velocity[:-1], states.acceleration[:-1]
    expected = {
        "position": step * (velocity + 0.5 * step * acceleration),
        "velocity": step * acceleration,
        "acceleration": 0.0 * step,
    }
    reached = trajectory.extremes().jerk
    jerk = np.maximum(np.abs(reached.lower), np.abs(reached.upper))
    allowed = (jerk * step**3 / 6.0, jerk * step**2 / 2.0, jerk * step)
    for (name, change), most in zip(expected.items(), allowed, strict=True):
        excess = np.abs(np.diff(getattr(states, name), axis=0) - change)
        # NaN is reported by the check of the limits
        yield name, excess - (1.0 + 1e-9) * most - JOINS * JOIN, states.time[:-1]
