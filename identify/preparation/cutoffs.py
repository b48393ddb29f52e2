"""Cut-off frequencies chosen from the data.

Positions are low-passed where they are below encoder noise. Torque and regressor are compared up to the
frequency at which the encoder's noise, twice differentiated and times inertia, would exceed the noise of
the current: beyond it, samples depend more on the encoder than on the arm.

A torque may also have been low-passed before it was recorded, by a controller or by whoever published it, and
positions were not. Dry friction steps at every reversal, and a step has power at all frequencies: a recording
that has none of it beyond some frequency was filtered there. What is compared beyond would look like friction
that reverses slowly: hysteresis.
"""

import numpy as np
from scipy import linalg, signal

from ..arm.derivatives import differentiate
from ..arm.motion import Motion
from ..model import Model
from .noise import smoothed

LOWEST = 5.0
"""Lowest cut-off [Hz]: a few times the base frequency of the motions arms are identified with."""
QUIET = 0.35
"""Share of the sample rate above which no arm follows; the spectrum there is noise."""
SMOOTHED_RATE = 50.0
"""Sample rate at which a torque and its fit are compared [Hz]: drives' slowest filters are below 10 Hz."""
WINDOW = 8.0
"""Length of a window of a spectrum [s], or a quarter of a shorter run."""
LOBES = ("kaiser", 12.0)
"""Window of the spectra: its side lobes are 90 dB down, its main lobe is half a hertz wide."""
ABSENT = 1e-3
"""Share of the power beyond a frequency that is nothing: 3 % of the amplitude. No presliding takes away so
much on all joints."""
TENTH = 0.1
"""Share of the power beyond a frequency that is left at nine tenths of a steep filter's cut-off, as the power
of steps falls by frequency squared."""


def spectra(values: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies (f,), one-sided densities (f, n) and white noise density (n,).

    Averaged over windows of 2 s, or an eighth of a shorter run.
    """
    length = int(max(16, min(2.0 * rate, len(values) / 8)))
    frequency, density = signal.welch(values, rate, nperseg=length, axis=0, detrend="linear")
    return frequency, density, np.median(density[frequency > QUIET * rate], axis=0)


def accelerations(position: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies (f,) and densities of the acceleration (f, n): measured, and that of encoder noise.

    Differentiation comes before the spectrum: the window's side lobes fall by frequency cubed, so
    that in a spectrum of positions the slow motion would cover everything up to tens of hertz.
    """
    frequency, density, _ = spectra(differentiate(position, rate)[1][3:-3], rate)
    noise = spectra(position, rate)[2] * (2 * np.pi * frequency[:, None]) ** 4
    return frequency, density, noise


def position_cutoff(position: np.ndarray, rate: float) -> float:
    """Highest frequency up to which some joint's acceleration stands above its encoder's noise [Hz].

    Above means four times the noise density, which an average over eight windows of noise alone
    exceeds with p < 1e-4 (chi-squared with sixteen degrees of freedom). That takes the noise for white.
    Jittering time stamps and filters in the controller colour it, but whatever its colour it grows once
    it is twice differentiated: an octave above the least acceleration, noise has long taken over.
    """
    frequency, density, noise = accelerations(position, rate)
    above = np.any(density > 4.0 * noise, axis=1) & (frequency < QUIET * rate)
    below = np.flatnonzero(~above[1:])  # the first unbroken stretch ends here, the lowest bin aside
    end = float(frequency[below[0] + 1] if len(below) else frequency[-1])
    return max(min(end, 2.0 * _valley(frequency, density, rate)), 1.5 * LOWEST)


def _valley(frequency: np.ndarray, density: np.ndarray, rate: float) -> float:
    """Frequency of the least acceleration above that of the fastest motion, the highest of all joints [Hz].

    The fastest, not the most accelerated: past the valley noise may accelerate more than the motion does.
    Infinite where it is less than 10 dB deep on some joint: scatter of the spectrum makes such dips too.
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

    For an octave, that is: a gap between a slow motion and a swept sine on top is narrower, and further
    up encoder noise, which grows by frequency to the fourth, comes back.
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

    White position noise gives torque noise M (2 pi f)^2 times its density. Where that meets the torque's
    own noise density, at f_x, the sum up to f_x holds a fifth more variance; up to 0.7 f_x, 5 % more.
    The joint that meets first decides.
    """
    inertia = nominal_inertia(model, np.mean(position, axis=0))
    encoder = np.sqrt(inertia**2 @ spectra(position, rate)[2])
    torque = np.abs(gain) * np.sqrt(spectra(current, rate)[2])
    share = torque / np.maximum(encoder, np.finfo(float).tiny)
    return float(0.7 * np.min(np.sqrt(share)) / (2 * np.pi))


def nominal_inertia(model: Model, posture: np.ndarray) -> np.ndarray:
    """Mass matrix from nominal values, rotors included, shape (n, n) [kg m^2]."""
    n = len(posture)
    still = np.zeros((n + 1, n))
    acceleration = np.vstack([np.zeros(n), np.eye(n)])
    motion = Motion.of(np.zeros(n + 1), still + posture, still, acceleration, temperature=still)
    torque = model.torque(model.loaded(motion), model.nominal_values)
    return (torque[1:] - torque[0]).T


def recorded_band(model: Model, motion: Motion, current: np.ndarray, rate: float) -> float:
    """Frequency up to which currents or torques (t, n) were recorded [Hz]; infinite if not smoothed before.

    `model` is nominal, `motion` the whole run at `rate` [Hz], `current` as measured.
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
    """Currents (t, n) by least squares of each joint, with friction of its own."""
    columns = model.regressor(model.loaded(motion))
    found = []
    for joint, measured in enumerate(current.T):
        velocity = motion.velocity[:, joint]
        own = np.column_stack([columns[:, joint], np.sign(velocity), velocity, np.ones(len(velocity))])
        own = own / np.maximum(np.linalg.norm(own, axis=0), 1e-300)
        found.append(own @ linalg.lstsq(own, measured, cond=1e-8)[0])
    return np.column_stack(found)


def _beyond(values: np.ndarray, rate: float, length: int) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (f,) [Hz], and power of columns (t, n) beyond each of them (f, n)."""
    frequency, density = signal.welch(values, rate, LOBES, length, axis=0, detrend="linear")
    return frequency, np.cumsum(density[::-1], axis=0)[::-1]
