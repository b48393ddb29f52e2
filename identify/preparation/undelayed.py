"""Removal of the delays in a model's measurements from recordings."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import make_interp_spline

from ..recordings.recording import EFFORT, Recording, Signal
from ..recordings.servo_error import delayed_command

DEGREE = 5
"""Degree of the spline between samples: at a quarter of the sampling rate it attenuates by 0.1 %; linear
interpolation would attenuate by a third."""


def without_delay(recording: Recording) -> Recording:
    """Recording whose efforts are shifted to the times at which they acted.

    If the error of servos stands for the current, their commands are shifted instead.
    """
    delay = recording.model.delay
    if not np.any(delay):
        return recording
    commanded = delayed_command(recording, -delay)
    if commanded is not None:
        return commanded
    moved = {name: _advanced(recording.signals[name], delay) for name in EFFORT if name in recording.signals}
    return replace(recording, signals={**recording.signals, **moved})


def _advanced(signal: Signal, delay: np.ndarray) -> Signal:
    """Signal shifted earlier by the delay of each joint (n,) [s], as long as all joints are known."""
    time = signal.time
    if len(time) <= DEGREE:
        return signal
    known = (time + delay.max() <= time[-1]) & (time + delay.min() >= time[0])
    return Signal(time[known], earlier(time, signal.values, delay)[known])


def earlier(time: np.ndarray, values: np.ndarray, seconds: np.ndarray) -> np.ndarray:
    """Values (t, n) on a time axis (t,) [s], with each column shifted earlier by its time `seconds` (n,) [s].

    Beyond the ends of the axis the values are constant; a column with gaps stays unchanged.
    """
    moved = np.array(values)
    for column in np.flatnonzero(seconds):
        if np.all(np.isfinite(values[:, column])):
            spline = make_interp_spline(time, values[:, column], DEGREE)
            moved[:, column] = spline(np.clip(time + seconds[column], time[0], time[-1]))
    return moved
