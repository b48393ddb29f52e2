"""Up to where a recorded torque was low-passed before it was recorded, by the friction that it lacks.

Dry friction steps at every reversal, and a step has power at all frequencies. A recording that has none of
it beyond some frequency was filtered, by a controller or by whoever published it, and positions were not.
What is compared beyond that frequency would look like friction that reverses slowly: hysteresis.
"""

import numpy as np
from scipy import linalg, signal

from ..arm.motion import Motion
from ..model import Model
from .noise import smoothed

RATE = 50.0
"""Sample rate at which the two are compared [Hz]: drives' slowest filters are below 10 Hz."""
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


def recorded_band(model: Model, motion: Motion, current: np.ndarray, rate: float) -> float:
    """Frequency up to which currents or torques (t, n) were recorded [Hz]; infinite if not smoothed before.

    Args:
        model: Nominal.
        motion: The whole run.
        current: As measured.
        rate: Of all samples [Hz].
    """
    if not smoothed(current, rate):
        return np.inf
    stride = max(int(rate / RATE), 1)
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
