"""Cut-off frequencies chosen from the data.

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

from ..arm.derivatives import differentiate
from ..arm.motion import Motion
from ..model import Model
from .noise import smoothed

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


def spectra(values: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
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
    frequency, density, _ = spectra(differentiate(position, rate)[1][3:-3], rate)
    noise = spectra(position, rate)[2] * (2 * np.pi * frequency[:, None]) ** 4
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
    encoder = np.sqrt(inertia**2 @ spectra(position, rate)[2])
    torque = np.abs(gain) * np.sqrt(spectra(current, rate)[2])
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
