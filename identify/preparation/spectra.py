"""Spectra of recorded signals: cut-off frequencies chosen from them, and the noise floor of each joint.

Positions are low-passed at the frequency above which encoder noise exceeds them. Torque and regressor are
compared up to the frequency at which the encoder's noise, differentiated twice and multiplied by inertia,
would exceed the noise of the current: beyond it, samples depend more on the encoder than on the arm.

A torque, unlike positions, may also have been low-passed before it was recorded, by a controller or by its
publisher. Dry friction steps at every reversal, and a step has power at all frequencies: a recording without
such power beyond some frequency was filtered there. If the comparison extended beyond it, the result would
look like friction that reverses slowly, that is, hysteresis.
"""

import numpy as np
from scipy import linalg, signal

from ..arm.motion import Motion, differentiate
from ..model import Model
from .filters import Decimation

LOWEST = 5.0
"""Lowest cut-off [Hz]: a few times the base frequency of the motions arms are identified with."""
QUIET = 0.35
"""Share of the sampling rate above which no arm moves; the spectrum there is noise."""
SMOOTHED_RATE = 50.0
"""Sampling rate at which a torque and its fit are compared [Hz]: drives' slowest filters are below 10 Hz."""
WINDOW = 8.0
"""Duration of a window of a spectrum [s]; a quarter of a shorter run."""
LOBES = ("kaiser", 12.0)
"""Window of the spectra: its side lobes are 90 dB down, its main lobe is half a hertz wide."""
ABSENT = 1e-3
"""Ratio of measured to fitted power beyond a frequency below which the power counts as absent: 3 % of the
amplitude. Presliding never removes that much on all joints."""
TENTH = 0.1
"""Ratio of measured to fitted power beyond nine tenths of a steep filter's cut-off, since the power of steps
falls with frequency squared."""


def noise_spectra(values: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies (f,), one-sided densities (f, n) and white noise density (n,).

    Densities are averages over windows of 2 s, or of an eighth of a shorter run.
    """
    length = int(max(16, min(2.0 * rate, len(values) / 8)))
    frequency, density = signal.welch(values, rate, nperseg=length, axis=0, detrend="linear")
    return frequency, density, np.median(density[frequency > QUIET * rate], axis=0)


def accelerations(position: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies (f,), and densities (f, n) of the measured acceleration and of encoder noise.

    Positions are differentiated before the spectrum is computed: the window's side lobes fall with frequency
    cubed, so in a spectrum of positions the slow motion would cover everything up to tens of hertz.
    """
    frequency, density, _ = noise_spectra(differentiate(position, rate)[1][3:-3], rate)
    noise = noise_spectra(position, rate)[2] * (2 * np.pi * frequency[:, None]) ** 4
    return frequency, density, noise


def position_cutoff(position: np.ndarray, rate: float) -> float:
    """Highest frequency up to which some joint's acceleration exceeds its encoder's noise [Hz].

    The threshold is four times the noise density, which an average over eight windows of white noise exceeds
    with p < 1e-4 (chi-squared with sixteen degrees of freedom). Jitter of the time stamps and filters in the
    controller color the noise. But noise of any color grows when it is differentiated twice, so an octave
    above the minimum of the acceleration it dominates.
    """
    frequency, density, noise = accelerations(position, rate)
    above = np.any(density > 4.0 * noise, axis=1) & (frequency < QUIET * rate)
    below = np.flatnonzero(~above[1:])  # the first unbroken stretch ends here, the lowest bin aside
    end = float(frequency[below[0] + 1] if len(below) else frequency[-1])
    return max(min(end, 2.0 * _valley(frequency, density, rate)), 1.5 * LOWEST)


def _valley(frequency: np.ndarray, density: np.ndarray, rate: float) -> float:
    """Frequency of the minimum of the acceleration above the peak of the velocity, the largest of all [Hz].

    The velocity marks the motion, since beyond the valley the acceleration of noise may exceed that of the
    motion. The result is infinite if the valley of some joint is less than 10 dB deep: scatter of the
    spectrum makes such dips too.
    """
    smooth = np.apply_along_axis(np.convolve, 0, density, np.ones(3) / 3, "same")
    inside = (frequency > 0) & (frequency < QUIET * rate)
    velocity = np.where(inside[:, None], density, 0.0) / np.maximum(frequency, frequency[1])[:, None] ** 2
    smooth[frequency >= QUIET * rate] = np.inf
    peaks = np.argmax(velocity, axis=0)
    lows = [peak + int(np.argmin(smooth[peak:, joint])) for joint, peak in enumerate(peaks)]
    joints = range(density.shape[1])
    deep = all(smooth[lows[j], j] < 0.1 * np.max(smooth[peaks[j] : lows[j] + 1, j]) for j in joints)
    return float(np.max(frequency[lows])) if deep else np.inf


def torque_cutoff(
    model: Model, position: np.ndarray, current: np.ndarray, gain: np.ndarray, rate: float
) -> float:
    """Frequency up to which torque is compared [Hz]."""
    crossing = noise_crossing(model, position, current, gain, rate)
    return max(motion_band(position, rate), crossing, LOWEST)


def motion_band(position: np.ndarray, rate: float) -> float:
    """Frequency from which every joint's acceleration stays 30 dB below its strongest line [Hz].

    It has to stay there for one octave: a gap between a slow motion and a superposed swept sine is narrower,
    and at higher frequencies encoder noise, which grows with frequency to the fourth, exceeds it again.
    """
    frequency, density, _ = accelerations(position, rate)
    weak = np.all(density < 1e-3 * np.maximum.accumulate(density, axis=0), axis=1)
    for place, start in enumerate(frequency):
        octave = (frequency >= start) & (frequency <= 2 * start)
        if place > 0 and np.all(weak[octave]):
            return float(start)
    return 0.0


def noise_crossing(
    model: Model, position: np.ndarray, current: np.ndarray, gain: np.ndarray, rate: float
) -> float:
    """Frequency up to which encoder noise adds at most 5 % to the torque's noise variance [Hz].

    White position noise causes torque noise of M (2 pi f)^2 times its density, which equals the noise density
    of the measured torque at f_x. It adds a fifth to the variance up to f_x, and 5 % to that up to 0.7 f_x.
    The joint with the lowest f_x determines the result.
    """
    inertia = nominal_inertia(model, np.mean(position, axis=0))
    encoder = np.sqrt(inertia**2 @ noise_spectra(position, rate)[2])
    torque = np.abs(gain) * np.sqrt(noise_spectra(current, rate)[2])
    share = torque / np.maximum(encoder, np.finfo(float).tiny)
    return float(0.7 * np.min(np.sqrt(share)) / (2 * np.pi))


def nominal_inertia(model: Model, posture: np.ndarray) -> np.ndarray:
    """Mass matrix from nominal values, including rotors, shape (n, n) [kg m^2]."""
    n = len(posture)
    still = np.zeros((n + 1, n))
    acceleration = np.vstack([np.zeros(n), np.eye(n)])
    motion = Motion.of(np.zeros(n + 1), still + posture, still, acceleration, temperature=still)
    torque = model.torque(model.loaded(motion), model.nominal_values)
    return (torque[1:] - torque[0]).T


def recorded_band(model: Model, motion: Motion, current: np.ndarray, rate: float) -> float:
    """Frequency up to which currents or torques were recorded [Hz]; infinite if they were not filtered.

    Args:
        model: Nominal model.
        motion: Motion of the run.
        current: Measured currents or torques, shape (t, n).
        rate: Sampling rate of both [Hz].
    """
    if not smoothed(current, rate):
        return np.inf
    stride = max(int(rate / SMOOTHED_RATE), 1)
    fitted = _fitted(model, motion[::stride], current[::stride])
    length = int(min(WINDOW * rate / stride, len(fitted) / 4))
    frequency, measured = _beyond(current[::stride], rate / stride, length)
    share = measured / np.maximum(_beyond(fitted, rate / stride, length)[1], 1e-300)
    if np.min(np.max(share, axis=1)) >= ABSENT:  # some joint has power everywhere
        return np.inf
    return float(frequency[np.argmax(np.median(share, axis=1) < TENTH)] / (1.0 - TENTH))


def _fitted(model: Model, motion: Motion, current: np.ndarray) -> np.ndarray:
    """Currents (t, n) from a least-squares fit of each joint, with Coulomb and viscous friction added."""
    rigid = model.regressor(model.loaded(motion))
    fits = []
    for joint, measured in enumerate(current.T):
        velocity = motion.velocity[:, joint]
        regressor = np.column_stack([rigid[:, joint], np.sign(velocity), velocity, np.ones(len(velocity))])
        regressor = regressor / np.maximum(np.linalg.norm(regressor, axis=0), 1e-300)
        fits.append(regressor @ linalg.lstsq(regressor, measured, cond=1e-8)[0])
    return np.column_stack(fits)


def _beyond(values: np.ndarray, rate: float, length: int) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (f,) [Hz], and power of the columns of values (t, n) beyond each frequency (f, n)."""
    frequency, density = signal.welch(values, rate, LOBES, length, axis=0, detrend="linear")
    return frequency, np.cumsum(density[::-1], axis=0)[::-1]


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
