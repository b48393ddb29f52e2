"""The largest torques of a trajectory, between samples too."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..trajectory import States, Trajectory

FINER = 16
"""Into how many parts the samples beside a peak are divided; what hides between falls with its square."""
PROMISING = 0.5
"""Share of its second difference that a sample is trusted to hide; a parabola hides an eighth."""
LEVEL = 1e-9
"""Relative difference of torques that is rounding: on a plateau one sample stands for all."""


class TorquePeaks(NamedTuple):
    """Extremes of each joint's torque, each of shape (n,).

    Attributes:
        lower: [N m].
        upper: [N m].
        lower_time: [s].
        upper_time: [s].
        hidden: What may hide between the finest samples if the torque bends no more than they show: an
            eighth of their largest second difference [N m].
    """

    lower: np.ndarray
    upper: np.ndarray
    lower_time: np.ndarray
    upper_time: np.ndarray
    hidden: np.ndarray


def torque_peaks(
    trajectory: Trajectory, torque: Callable[[States], np.ndarray], spacing: float
) -> TorquePeaks:
    """Largest and smallest torque, refined around every sample that could hide a larger one.

    A peak elsewhere would have to bend four times as much as the samples around it do.

    Args:
        trajectory: Anything longer than no time.
        torque: Shape (t, n) [N m] for given states; each sample on its own, without memory.
        spacing: Of the first samples, at most [s].
    """
    count = max(int(np.ceil(trajectory.duration / spacing - 1e-6)), 2)
    time, step = np.linspace(0.0, trajectory.duration, count + 1, retstep=True)
    coarse = _both_signs(torque(trajectory.at(time)))
    centres = np.clip(time[_worth_a_look(coarse)], step, trajectory.duration - step)
    near = centres[:, None] + step * np.linspace(-1.0, 1.0, 2 * FINER + 1)
    near = np.clip(near, 0.0, trajectory.duration)  # rounding
    fine = _both_signs(torque(trajectory.at(near.ravel()))).reshape(*near.shape, -1)
    bend = np.abs(np.diff(fine, 2, axis=1)) / 8
    values = _vertices(fine).reshape(-1, fine.shape[-1])
    best = np.argmax(values, axis=0)
    highest, when = values[best, np.arange(len(best))], near.ravel()[best]
    (upper, lower), (upper_time, lower_time) = np.split(highest, 2), np.split(when, 2)
    hidden = np.max(np.split(bend.max(axis=(0, 1)), 2), axis=0)
    return TorquePeaks(-lower, upper, lower_time, upper_time, hidden)


def _both_signs(torque: np.ndarray) -> np.ndarray:
    """Torque and its negative side by side, so that every extreme is a maximum; (t, n) to (t, 2 n)."""
    return np.concatenate([torque, -torque], axis=1)


def _worth_a_look(values: np.ndarray) -> np.ndarray:
    """Rows at which some column may be larger than its largest sample."""
    bend = np.pad(np.abs(np.diff(values, 2, axis=0)), ((1, 1), (0, 0)), mode="edge")
    highest = values.max(axis=0)
    hopeful = values + PROMISING * bend > highest + LEVEL * np.abs(highest)
    hopeful[np.argmax(values, axis=0), np.arange(values.shape[1])] = True
    return np.flatnonzero(np.any(hopeful, axis=1))


def _vertices(values: np.ndarray) -> np.ndarray:
    """Samples (m, samples, columns), each peak among them raised to the top of its parabola."""
    before, here, after = values[:, :-2], values[:, 1:-1], values[:, 2:]
    bend = 2 * here - before - after
    peak = (here >= before) & (here >= after) & (bend > 0.0)
    raised = values.copy()
    raised[:, 1:-1] += np.where(peak, (after - before) ** 2 / (8 * np.where(peak, bend, 1.0)), 0.0)
    return raised
