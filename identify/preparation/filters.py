"""Zero-phase filters (paper, section III): low-pass, parallel decimation, and removal of known delays."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import interpolate, signal
from scipy.interpolate import make_interp_spline

from ..recordings.recording import EFFORT, Recording, Signal
from ..recordings.servo_error import delayed_command

CLOSE = 0.25
"""Gap between two time stamps, over the median gap, below which their samples are averaged. A cubic through
both would spread their noise over a period, and multiply it by one over this ratio."""

BLOCK = 8
"""Filter outputs that one matrix product computes: with more, most products would be with zeros."""


def uniform(time: np.ndarray, values: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Even time axis at a rate [Hz] between the first and last time stamp, and resampled values.

    Stamps (t,) [s] increase. Values (t, n) are interpolated with a cubic spline. Samples whose stamps nearly
    coincide, such as those of messages that arrived late, are averaged.
    """
    count = int(np.floor((time[-1] - time[0]) * rate + 1e-6)) + 1
    even = time[0] + np.arange(count) / rate
    if count == len(time) and np.max(np.abs(time - even)) < 1e-3 / rate:
        return even, values
    return even, interpolate.CubicSpline(*_merged(time, values))(even)


def _merged(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Stamps (t,) and values (t, n), where samples whose stamps nearly coincide are averaged."""
    gaps = np.diff(time)
    starts = np.flatnonzero(np.append(True, gaps >= CLOSE * np.median(gaps)))
    if len(starts) == len(time):
        return time, values
    counts = np.diff(np.append(starts, len(time)))
    return np.add.reduceat(time, starts) / counts, np.add.reduceat(values, starts) / counts[:, None]


def low_pass(values: np.ndarray, rate: float, cutoff: float) -> np.ndarray:
    """Fourth-order Butterworth forward and backward along time; no filter at or above Nyquist."""
    if cutoff >= 0.5 * rate:
        return values
    sections = signal.butter(4, cutoff, fs=rate, output="sos")
    pad = min(len(values) - 1, int(3 * rate / cutoff))
    return signal.sosfiltfilt(sections, values, axis=0, padlen=pad)


@dataclass(frozen=True)
class Decimation:
    """Linear-phase low-pass and downsampling, identical for torque and for every regressor column."""

    rate: float  # sampling rate of the input before thinning [Hz]
    cutoff: float  # half-amplitude frequency [Hz]
    factor: int  # ratio of `rate` to the sampling rate of the output
    step: int = 1  # ratio of `rate` to the actual sampling rate of the input; a divisor of `factor`

    @classmethod
    def at(cls, rate: float, cutoff: float) -> "Decimation":
        """Decimation whose output band just contains the filter's: cut-off at 0.8 of the new Nyquist rate.

        The factor is a product of 2, 3 and 5, so that `thinned` can choose among its divisors.
        """
        most = max(1, int(0.4 * rate / cutoff))
        factor = next(k for k in range(most, 0, -1) if pow(30, 20, k) == 0)  # it divides a power of 30
        return cls(rate, min(cutoff, 0.5 * rate), factor)

    def thinned(self, rate: float) -> "Decimation":
        """The same filter for an input that is sampled at a lower rate, at least `rate` [Hz]."""
        steps = [k for k in range(1, self.factor + 1) if self.factor % k == 0 and self.rate / k >= rate]
        return replace(self, step=max(steps, default=1))

    @property
    def output_rate(self) -> float:
        """Sampling rate of the output [Hz]."""
        return self.rate / self.factor

    @property
    def stride(self) -> int:
        """Input samples per output sample."""
        return self.factor // self.step

    @property
    def half(self) -> int:
        """Half length of the filter in input samples, a multiple of the stride.

        Its transition band is half of the cut-off wide (Kaiser, 5 / length), so that attenuation reaches
        81 dB at the end of the output's band.
        """
        return self.stride * int(np.ceil(5.0 * self.rate / self.cutoff / self.factor))

    @cached_property
    def taps(self) -> np.ndarray:
        """Filter coefficients, shape (2 half + 1,), sum 1."""
        if self.cutoff >= 0.5 * self.rate:
            return np.ones(1)
        # As the filter attenuates high frequencies, every step-th tap gives the same response at low ones.
        length = 2 * self.half * self.step + 1
        taps = signal.firwin(length, self.cutoff, fs=self.rate, window=("kaiser", 8.0))[:: self.step]
        return taps / np.sum(taps)

    def centres(self, samples: int) -> np.ndarray:
        """Indices of the samples on which the outputs are centered; filters never extend beyond the data."""
        half = (len(self.taps) - 1) // 2
        return np.arange(half, samples - half, self.stride)

    def apply(self, values: np.ndarray) -> np.ndarray:
        """Filter and downsample along time, shape (t, ...) -> (centers, ...)."""
        taps, stride = self.taps, self.stride
        count = len(self.centres(len(values)))
        flat = np.ascontiguousarray(values.reshape(len(values), -1))
        out = np.empty((count, flat.shape[1]))
        if not count:
            return out.reshape(0, *values.shape[1:])
        # A block of outputs is one small matrix product, with the same matrix for all blocks.
        block = min(BLOCK, count)
        matrix = np.zeros((block, (block - 1) * stride + len(taps)))
        for row in range(block):
            matrix[row, row * stride : row * stride + len(taps)] = taps
        blocks, (along, across) = count // block, flat.strides
        inputs = np.lib.stride_tricks.as_strided(
            flat,
            (blocks, matrix.shape[1], flat.shape[1]),
            (block * stride * along, along, across),
            writeable=False,
        )
        np.matmul(matrix, inputs, out=out[: blocks * block].reshape(blocks, block, -1))
        if remaining := count - blocks * block:
            last = flat[blocks * block * stride :][: (remaining - 1) * stride + len(taps)]
            out[blocks * block :] = matrix[:remaining, : len(last)] @ last
        return out.reshape(count, *values.shape[1:])

    def stream(self, pieces: Iterable[np.ndarray]) -> np.ndarray:
        """Result of `apply` to a signal that comes in consecutive pieces, each (t, ...)."""
        ready: list[np.ndarray] = []
        waiting: np.ndarray | None = None
        for piece in pieces:
            waiting = piece if waiting is None else np.concatenate([waiting, piece])
            ready.append(self.apply(waiting))
            # The samples that the next output still needs are kept for the next piece.
            waiting = waiting[len(ready[-1]) * self.stride :]
        return np.concatenate(ready)


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
