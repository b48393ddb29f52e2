"""Recordings without the delays that their model holds."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import make_interp_spline

from ..recordings.recording import EFFORT, Recording, Signal
from ..recordings.servo_error import delayed_command

DEGREE = 5
"""Degree of the spline between samples: at a quarter of the sampling rate it loses 0.1 %, and a straight line
would lose a third, noise included."""


def without_delay(recording: Recording) -> Recording:
    """The recording with efforts at the times at which they acted.

    Where the error of servos stands for the current, their commands are moved.
    """
    delay = recording.model.delay
    if not np.any(delay):
        return recording
    commanded = delayed_command(recording, -delay)
    if commanded is not None:
        return commanded
    moved = {name: _without(recording.signals[name], delay) for name in EFFORT if name in recording.signals}
    return replace(recording, signals={**recording.signals, **moved})


def _without(signal: Signal, delay: np.ndarray) -> Signal:
    """A signal at the times at which it was, as long as all joints were recorded."""
    time = signal.time
    if len(time) <= DEGREE:
        return signal
    known = (time + delay.max() <= time[-1]) & (time + delay.min() >= time[0])
    return Signal(time[known], earlier(time, signal.values, delay)[known])


def earlier(time: np.ndarray, values: np.ndarray, seconds: np.ndarray) -> np.ndarray:
    """Values (t, n) of a time axis (t,) [s], each column earlier by its number of seconds (n,).

    Beyond the ends of the axis, those of the end; a column with gaps stays as it is.
    """
    moved = np.array(values)
    for column in np.flatnonzero(seconds):
        if np.all(np.isfinite(values[:, column])):
            spline = make_interp_spline(time, values[:, column], DEGREE)
            moved[:, column] = spline(np.clip(time + seconds[column], time[0], time[-1]))
    return moved
