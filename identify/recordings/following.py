"""How late an arm follows its commands: of drives and their smoothing, and in no measurement."""

import numpy as np

from .recording import Signal

MOST = 0.3
"""Latency up to which is looked for [s]: more than any drive has that can be streamed to."""
STEP = 0.001
"""Between latencies that are tried; a parabola finds what lies between [s]."""
SAMPLES = 4000
"""Positions that are looked at, at most."""
LEAST = 1e-3
"""Way of commands below which none can be seen [rad]."""


def follows_by(command: Signal, position: Signal) -> float:
    """By how much positions are behind commands, in least squares over all joints [s]; NaN where unseen.

    A steady distance, as of a joint that bears a load, does not count.
    """
    if len(command) < 2 or np.nanmax(np.ptp(command.values, axis=0)) < LEAST:
        return float("nan")
    inside = (position.time >= command.time[0] + MOST) & (position.time <= command.time[-1])
    rows = np.flatnonzero(inside & np.isfinite(position.values).all(axis=1))
    rows = rows[:: max(len(rows) // SAMPLES, 1)]
    if len(rows) < 10:
        return float("nan")
    time, values = position.time[rows], position.values[rows]
    latencies = np.arange(0.0, MOST + 0.5 * STEP, STEP)
    left = np.array([_distance(command, time - latency, values) for latency in latencies])
    best = int(np.argmin(left))
    if best in (0, len(left) - 1):
        return float(latencies[best]) if best == 0 else float("nan")
    before, here, after = left[best - 1 : best + 2]
    return float(latencies[best] + 0.5 * STEP * (before - after) / (before - 2.0 * here + after))


def _distance(command: Signal, time: np.ndarray, values: np.ndarray) -> float:
    """Sum of squares of positions away from commands at a time, but for the mean of each joint [rad^2]."""
    commanded = np.column_stack([np.interp(time, command.time, joint) for joint in command.values.T])
    away = values - commanded
    return float(np.sum((away - away.mean(axis=0)) ** 2))
