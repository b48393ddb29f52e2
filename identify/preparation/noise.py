"""Colored noise: its spectrum, and the noise floor of each joint.

Current noise and residuals at 500 Hz are far from white, and they are correlated between joints.
"""

from collections.abc import Sequence

import numpy as np
from scipy import signal

from .filters import Decimation


def autocovariance(pieces: Sequence[np.ndarray], weights: Sequence[np.ndarray], lags: int) -> np.ndarray:
    """Covariance of x(k) with x(k - lag) over pieces of signals (t, n), shape (lags + 1, n, n).

    Rows with zero weight count as zeros, and every lag is divided by the same number of rows. Unlike means
    over the rows of each lag, the sequence is then positive semi-definite for any gaps.
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
    """Variance density at `count` or more even frequencies round the circle, shape (count, n, n).

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


PARZEN = 0.539
"""Variance of a density at one frequency, over its square and over lags per row, for Parzen's window
(Priestley 1981, table 6.1)."""


def shrunk(covariance: np.ndarray, rows: float) -> np.ndarray:
    r"""Autocovariances (lags + 1, n, n) from a number of rows, with their chance correlations reduced.

    Independent signals of finite length seem correlated. The variance of each cross spectrum,
    :math:`v\,S_{ii} S_{jj}` with v = `PARZEN` * lags / rows, adds up over the pairs of seven joints: the
    combinations with least noise then seem up to 40 % less noisy than they are. All cross covariances are
    multiplied by the factor with the least mean squared error, as Ledoit and Wolf (2004) do for covariances.
    """
    lags, n = len(covariance) - 1, covariance.shape[1]
    size = np.sqrt(np.maximum(np.diagonal(covariance[0]), np.finfo(float).tiny))
    density = spectrum(covariance / np.outer(size, size), 1)
    power = np.diagonal(density, axis1=1, axis2=2).real
    between = ~np.eye(n, dtype=bool)
    chance = PARZEN * lags / rows * np.sum((power.T @ power)[between])
    seen = np.sum(np.abs(density[:, between]) ** 2)
    share = max(0.0, 1.0 - chance / seen) if seen > 0.0 else 0.0
    return covariance * np.where(between, share, 1.0)


def noise_at_rest(
    current: np.ndarray, still: np.ndarray, decimation: Decimation, shortest: float = 0.25
) -> np.ndarray:
    """Noise of each current behind the decimation filter, from the times when no joint moves.

    Args:
        current: Currents, shape (t, n).
        still: Whether all joints are at rest, shape (t,).
        decimation: Filter through which torque is compared.
        shortest: Minimum duration of a rest that is used [s].

    Returns:
        Standard deviation, shape (n,); NaN if the arm rests for less than two periods of the cut-off.
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
    """Spans of rest before the first motion, and spans of rest after a motion.

    A tenth of a second is cut off where a motion starts or stops, since the filters smear both.
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
    """One-sided noise density (f, n) of a piece (t, n) at the requested frequencies.

    After a motion a stuck joint creeps, so a straight line is removed; before the first motion a mean
    suffices. The line also removes the lowest two bins of the noise, and the mean the lowest bin; they are
    replaced by the bins above.
    """
    bins, density = signal.periodogram(piece, rate, axis=0, detrend=line)
    if line == "linear":
        density[:2] = np.mean(density[2:4], axis=0)
    else:
        density[0] = density[1]
    return np.stack([np.interp(frequency, bins, column) for column in density.T], axis=1)


def quantization(current: np.ndarray, decimation: Decimation) -> np.ndarray:
    """Quantization noise of a recorded current (t, n) behind the decimation filter, shape (n,).

    A coarsely quantized current is constant while the arm rests, and so seems free of noise; in motion its
    error is white and uniform over a step.
    """
    steps = np.abs(np.diff(current, axis=0))
    step = np.min(np.where(steps > 0, steps, np.inf), axis=0, initial=np.inf)
    return np.where(np.isfinite(step), step, 0.0) / np.sqrt(12) * np.linalg.norm(decimation.taps)


STEEP = 50.0
"""Ratio of the noise density a third below the Nyquist frequency to that near it, above which a signal was
low-passed before it was recorded. It is 1 for white noise, 2 for noise that falls with frequency squared, and
200 behind a second-order filter with one pass."""
EMPTY = 1e-7
"""Ratio of the noise near the Nyquist frequency to the signal below which it is rounding: converters have 24
bits."""


def smoothed(current: np.ndarray, rate: float) -> bool:
    """Whether a current (t, n) was low-passed before it was recorded: no noise remains near half its rate.

    Noise at rest, or at frequencies above the motion, then underestimates the noise in motion: the filter has
    removed part of it, and part of the arm's response too.
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
    """Noise of each current behind the filter, assumed as strong below the cut-off as above it, shape (n,).

    This is a lower bound if the noise is colored; it is used if the arm never rests.
    """
    rate, cutoff = decimation.rate, decimation.cutoff
    spectrum = np.abs(np.fft.rfft(current * np.hanning(len(current))[:, None], axis=0)) ** 2
    frequency = np.fft.rfftfreq(len(current), 1 / rate)
    # Halfway between cut-off and Nyquist frequency no motion remains. The median ignores ripple lines; for a
    # chi-squared with two degrees of freedom it is ln 2 times the mean.
    quiet = frequency > 0.5 * (cutoff + 0.5 * rate)
    if not np.any(quiet):
        return np.full(current.shape[1], np.nan)
    density = np.median(spectrum[quiet], axis=0) / np.log(2) / np.sum(np.hanning(len(current)) ** 2)
    return np.sqrt(density * np.sum(decimation.taps**2))
