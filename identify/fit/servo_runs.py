"""Runs as the identification of servos needs them: low-passed signals on an even time axis."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.stats import norm

from ..arm.motion import differentiate
from ..preparation.even import Even
from ..preparation.filters import low_pass
from ..preparation.spectra import position_cutoff
from ..recordings.recording import Recording

LONGEST = 0.15
"""Longest delay of a command that is considered [s]: five cycles of a 30 Hz bus."""


@dataclass(frozen=True, eq=False)
class ServoRun:
    """Signals of one run; n joints."""

    rate: float  # sampling rate [Hz]
    cutoff: float  # cut-off of the low-pass that all signals but `raw_torque` have passed [Hz]
    position: np.ndarray  # positions, shape (t, n) [rad]
    velocity: np.ndarray  # velocities, shape (t, n) [rad/s]
    torque: np.ndarray  # torques, shape (t, n) [N m]
    raw_torque: np.ndarray  # torques before the low-pass, shape (t, n) [N m]
    noise: np.ndarray  # standard deviation of the noise that is left in `torque`, shape (n,) [N m]
    command: CubicSpline  # commands as functions of the time since the first sample

    @classmethod
    def of(cls, recording: Recording, gain: np.ndarray) -> "ServoRun":
        """Signals of a recording with commands and effort; `gain` (n,) is the torque per current [N m/A]."""
        even = Even.of(recording, None)
        cutoff = position_cutoff(even.position, even.rate)
        position, command, torque = (
            low_pass(values, even.rate, cutoff)
            for values in (even.position, even.signal("command"), even.signal(even.measures))
        )
        scale = np.ones(len(gain)) if even.measures == "torque" else gain
        torque, raw_torque = scale * torque, scale * even.signal(even.measures)
        return cls(
            even.rate, cutoff, position, differentiate(position, even.rate)[0], torque, raw_torque,
            _passed_noise(raw_torque - torque, cutoff / (0.5 * even.rate)),
            CubicSpline(even.time - even.time[0], command),
        )  # fmt: skip

    @property
    def inside(self) -> slice:
        """Samples away from the transients of the filters, thinned to the band of the low-pass."""
        edge = int(self.rate * (LONGEST + 2.0 / self.cutoff))
        return slice(edge, len(self.position) - edge, max(1, int(self.rate / (4.0 * self.cutoff))))

    @property
    def time(self) -> np.ndarray:
        """Time since the first sample, shape (t,) [s]."""
        return np.arange(len(self.position)) / self.rate


def _passed_noise(removed: np.ndarray, share: float) -> np.ndarray:
    """Standard deviation of white noise behind a low-pass, from the part that it removed, shape (n,).

    The median leaves out jumps of friction, which a low-pass removes too.

    Args:
        removed: Signals less those behind the low-pass, shape (t, n).
        share: Cut-off over half of the sampling rate.
    """
    size = np.median(np.abs(removed - np.median(removed, axis=0)), axis=0) / norm.ppf(0.75)
    return np.asarray(size * np.sqrt(share / max(1.0 - share, share)))
