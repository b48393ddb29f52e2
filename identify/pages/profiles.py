"""Profiles of a residual over recorded quantities, and its spectra."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..diagnosis.findings.axes import AXES as AXES
from ..diagnosis.findings.axes import Axis
from ..diagnosis.findings.evidence import Trace

BINS = 28
"""Number of bins in a profile; in a run of half a minute, each has some hundred rows."""
FEWEST = 8
"""Smallest number of rows for which the mean of a bin is drawn."""
USUAL = ("velocity", "position", "load", "acceleration", "time", "motor angle")
"""Axes on which an unexplained residual is drawn."""


class Profile(NamedTuple):
    """Means of a residual in bins."""

    x: np.ndarray  # middle of each bin, shape (b,)
    mean: np.ndarray  # mean residual in each bin, shape (b,) [N m]
    dots: np.ndarray  # value on the axis and residual of every row, shape (r, 2)


def profile(traces: Sequence[Trace], joint: int, axis: Axis, residuals: str) -> Profile:
    """A joint's residual against an axis.

    Args:
        traces: Traces of the runs to draw.
        joint: Index of the joint, from 0.
        axis: Horizontal axis.
        residuals: "before" or "after".
    """
    x, y = [], []
    for trace in traces:
        sliding = trace.weight[:, joint] > 0
        sign = np.sign(trace.velocity[:, joint]) if axis.braking else 1.0
        x.append(axis.values(trace, joint)[sliding])
        y.append((getattr(trace, residuals)[:, joint] * sign)[sliding])
    dots = np.column_stack([np.concatenate(x), np.concatenate(y)])
    dots = dots[np.all(np.isfinite(dots), axis=1)]
    return Profile(*_means(dots), dots)


def _means(dots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middles and means of bins of equal width that have enough rows."""
    if len(dots) < FEWEST or np.ptp(dots[:, 0]) == 0.0:
        return np.zeros(0), np.zeros(0)
    edges = np.linspace(dots[:, 0].min(), dots[:, 0].max(), BINS + 1)
    places = np.clip(np.digitize(dots[:, 0], edges) - 1, 0, BINS - 1)
    counts = np.bincount(places, minlength=BINS)
    sums = [np.bincount(places, dots[:, column], minlength=BINS) for column in (0, 1)]
    enough = counts >= FEWEST
    return sums[0][enough] / counts[enough], sums[1][enough] / counts[enough]


def spectrum(trace: Trace, joint: int, residuals: str) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and amplitudes [N m] of a joint's residual, averaged to a smooth line."""
    values = getattr(trace, residuals)[:, joint] * trace.weight[:, joint]
    rate = 1.0 / float(np.median(np.diff(trace.time)))
    length = min(256, len(values))
    window = np.hanning(length)
    starts = range(0, len(values) - length + 1, length // 2)
    pieces = np.array([values[start : start + length] for start in starts]) * window
    power = np.mean(np.abs(np.fft.rfft(pieces, axis=1)) ** 2, axis=0)
    return np.fft.rfftfreq(length, 1.0 / rate), 2.0 * np.sqrt(power) / window.sum()


def orders(traces: Sequence[Trace], joint: int, residuals: str, motor: bool) -> tuple[np.ndarray, np.ndarray]:
    """Waves per turn of the joint or of its motor, and the residual's amplitude at each [N m]."""
    angle = np.concatenate([(t.motor_angle if motor else t.position)[:, joint] for t in traces])
    values = np.concatenate([getattr(t, residuals)[:, joint] * t.weight[:, joint] for t in traces])
    count = np.arange(0.25, 8.01, 0.05)
    waves = np.exp(-1j * count[:, None] * angle)
    return count, 2.0 * np.abs(waves @ values) / max(len(values), 1)
