"""Coloured noise: its spectrum, and each joint's noise floor.

Current noise and residuals at 500 Hz are far from white, and those of several joints are correlated.
"""

from collections.abc import Sequence

import numpy as np
from scipy import signal

from .filters import Decimation


def autocovariance(pieces: Sequence[np.ndarray], weights: Sequence[np.ndarray], lags: int) -> np.ndarray:
    """Covariance of x(k) with x(k - lag) over pieces of signals (t, n), shape (lags + 1, n, n).

    Rows with zero weight count as zeros, and every lag is divided by the same number of rows: the
    sequence is then positive semi-definite whatever the gaps, which lag-by-lag means are not.
    """
    n = pieces[0].shape[1]
    products, counts = np.zeros((lags + 1, n, n)), np.zeros(n)
    for piece, weight in zip(pieces, weights, strict=True):
        masked = piece * weight
        counts += np.sum(weight**2, axis=0)
        for lag in range(min(lags + 1, len(piece))):
            products[lag] += masked[lag:].T @ masked[: len(piece) - lag]
    size = np.sqrt(np.maximum(counts, 1.0))
    return products / np.outer(size, size)


def spectrum(covariance: np.ndarray, count: int) -> np.ndarray:
    """Variance density at `count` even frequencies round the circle, shape (count, n, n).

    Autocovariances (lags + 1, n, n) are weighted by Parzen's window, which keeps the density positive
    semi-definite; its mean over the circle is the covariance at lag zero.
    """
    lags = len(covariance) - 1
    count = max(count, 2 * lags + 1)
    window = signal.windows.parzen(2 * lags + 1)[lags:]
    sequence = np.zeros((count, *covariance.shape[1:]))
    sequence[: lags + 1] = window[:, None, None] * covariance
    sequence[count - lags :] = np.swapaxes(sequence[lags:0:-1], 1, 2)
    return np.fft.fft(sequence, axis=0)


def noise_at_rest(
    current: np.ndarray, still: np.ndarray, decimation: Decimation, shortest: float = 0.25
) -> np.ndarray:
    """Noise of each current behind the decimation filter, from the times when no joint moves.

    Args:
        current: Shape (t, n).
        still: Whether the whole arm rests, shape (t,).
        decimation: The filter through which torque is compared.
        shortest: Pieces of rest shorter than this are left out [s].

    Returns:
        Standard deviation, shape (n,); NaN where the arm rests for less than two periods of the cut-off.
    """
    before, after = _rests(still, decimation.rate, shortest)
    spans, line = (before, "constant") if before else (after, "linear")
    if sum(b - a for a, b in spans) < 2 * decimation.rate / decimation.cutoff:
        return np.full(current.shape[1], np.nan)
    frequency = np.arange(0.25, 0.5 * decimation.rate, 0.5)  # middles of bands of 0.5 Hz
    densities = [_density(current[a:b], decimation.rate, frequency, line) for a, b in spans]
    density = np.average(densities, axis=0, weights=[b - a for a, b in spans])
    circle = np.exp(-2j * np.pi * np.outer(frequency, np.arange(len(decimation.taps))) / decimation.rate)
    response = np.abs(circle @ decimation.taps) ** 2
    return np.sqrt(0.5 * response @ density)


def _rests(still: np.ndarray, rate: float, shortest: float) -> tuple[list, list]:
    """Spans of rest before the first motion, and after some motion.

    A tenth of a second is cut off where a motion starts or stops: the filters smear both.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    margin = int(0.1 * rate)
    spans = [
        (a + margin * (a > 0), b - margin * (b < len(still)))
        for a, b in zip(edges[::2], edges[1::2], strict=True)
    ]
    spans = [(a, b) for a, b in spans if b - a >= shortest * rate]
    return [span for span in spans if span[0] == 0], [span for span in spans if span[0] > 0]


def _density(piece: np.ndarray, rate: float, frequency: np.ndarray, line: str) -> np.ndarray:
    """One-sided noise density (f, n) of a piece (t, n) at given frequencies.

    After a motion a stuck joint creeps, so a straight line is taken out; before one a mean will do. The
    line takes the lowest two bins of the noise with it, the mean the lowest one; the next stand for them.
    """
    bins, density = signal.periodogram(piece, rate, axis=0, detrend=line)
    if line == "linear":
        density[:2] = np.mean(density[2:4], axis=0)
    else:
        density[0] = density[1]
    return np.stack([np.interp(frequency, bins, column) for column in density.T], axis=1)


def quantisation(current: np.ndarray, decimation: Decimation) -> np.ndarray:
    """Noise that the resolution of a current as recorded (t, n) leaves behind the filter, shape (n,).

    A coarse current is constant while the arm rests, and so seems to be without noise; in motion its
    error is white and uniform over a step.
    """
    steps = np.abs(np.diff(current, axis=0))
    step = np.min(np.where(steps > 0, steps, np.inf), axis=0, initial=np.inf)
    return np.where(np.isfinite(step), step, 0.0) / np.sqrt(12) * np.linalg.norm(decimation.taps)


STEEP = 50.0
"""Density of a record a third below half its rate over that near it, from which it was low-passed before:
white noise has 1, noise that falls by frequency squared 2, a filter of second order with one pass 200."""
EMPTY = 1e-7
"""Noise near half the rate over the whole signal below which it is rounding: converters have 24 bits."""


def smoothed(current: np.ndarray, rate: float) -> bool:
    """Whether a current (t, n) was low-passed before it was recorded: no noise is left near half its rate.

    What is then seen at rest, or above the motion, is not the noise of a motion: the filter has taken a part
    of both, and of the arm's answer as well.
    """
    window = ("kaiser", 20.0)  # its side lobes are lower than the noise of any converter
    length = int(max(16, min(2.0 * rate, len(current) / 8)))
    frequency, density = signal.welch(current, rate, window, length, axis=0, detrend="linear")

    def level(low: float, high: float) -> np.ndarray:
        return np.median(density[(frequency >= low * rate) & (frequency < high * rate)], axis=0)

    top, size = level(0.4, 0.5), np.std(current, axis=0)
    moved = size > 0.0
    empty = np.sqrt(0.5 * rate * top[moved]) < EMPTY * size[moved]
    steep = level(0.3, 0.35)[moved] > STEEP * top[moved]
    return bool(np.any(moved) and np.mean(steep | empty) > 0.5)


def noise_above(current: np.ndarray, decimation: Decimation) -> np.ndarray:
    """Noise of each current behind the filter if it is as strong below the cut-off as above it, (n,).

    A lower bound where the noise is coloured; used when the arm never rests.
    """
    rate, cutoff = decimation.rate, decimation.cutoff
    spectrum = np.abs(np.fft.rfft(current * np.hanning(len(current))[:, None], axis=0)) ** 2
    frequency = np.fft.rfftfreq(len(current), 1 / rate)
    # Half-way between cut-off and Nyquist the motion is gone; the median ignores ripple lines, and
    # that of a chi-squared with two degrees of freedom is ln 2 of its mean.
    quiet = frequency > 0.5 * (cutoff + 0.5 * rate)
    if not np.any(quiet):
        return np.full(current.shape[1], np.nan)
    density = np.median(spectrum[quiet], axis=0) / np.log(2) / np.sum(np.hanning(len(current)) ** 2)
    return np.sqrt(density * np.sum(decimation.taps**2))
