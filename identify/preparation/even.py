"""A recording on an even time axis: its motion, its effort, and samples in which that is no measurement.

Those are samples in which a drive was off, and samples beyond the range of a current sensor.
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from ..arm.motion import Motion, differentiate
from ..errors import NotRecorded, RecordingError
from ..model import Model
from ..recordings.recording import EFFORT, Recording
from .filters import low_pass, uniform, without_delay

FEWEST = 64
"""Minimum number of samples for a spectrum from which filters are chosen; filters need more anyway."""
OFF = 0.2
"""Minimum duration of a stretch of exactly zero current for a drive to count as off [s]; the current of an
active drive only crosses zero."""
MOVED = 0.02
"""Minimum motion in such a stretch, as a share of the joint's range; at rest, a current may be zero."""


@dataclass(frozen=True)
class Even:
    """A recording on an even time axis, not yet filtered."""

    recording: Recording  # recording of one run
    time: np.ndarray  # even time axis, shape (t,) [s]
    position: np.ndarray  # joint positions, shape (t, n) [rad]
    rate: float  # sampling rate [Hz]
    measures: str  # measured effort, "current" or "torque"

    @classmethod
    def of(cls, recording: Recording, rate: float | None) -> "Even":
        """Resample the overlap of position and effort, by default at the median rate [Hz].

        Raises:
            NotRecorded: Neither currents nor torques were recorded.
            RecordingError: There are too few samples.
        """
        recording = without_delay(recording)
        signal = recording.signals["position"]
        if len(signal) < FEWEST:
            raise RecordingError(
                f"{recording.name}: only {len(signal)} samples; record at least some seconds"
            )
        # Time stamps are whole nanoseconds, which determine the rate to about 1 mHz.
        rate = rate or round(1.0 / signal.period, 3)
        time, position = uniform(signal.time, signal.values, rate)
        measures = next((name for name in EFFORT if len(recording.signals.get(name, ()))), "")
        if not measures:
            raise NotRecorded(
                f"{recording.name}: neither motor currents nor torques were recorded; set the controller up "
                "to send them, or put a trace of it beside the run (exidyn import --align)"
            )
        # Samples in which only position or only effort was recorded cannot be compared.
        effort = recording.signals[measures].time
        overlap = (time > effort[0] - 1.5 / rate) & (time < effort[-1] + 1.5 / rate)
        if np.count_nonzero(overlap) < FEWEST:
            raise RecordingError(
                f"{recording.name}: position and {measures} share only {np.count_nonzero(overlap)} samples; "
                "are their time stamps from one clock?"
            )
        return cls(recording, time[overlap], position[overlap], rate, measures)

    @property
    def gain(self) -> np.ndarray:
        """Nominal torque per unit of the measured effort, shape (n,)."""
        known = self.measures == "torque"
        return np.ones(self.position.shape[1]) if known else self.recording.robot.drive_gain

    def signal(self, name: str) -> np.ndarray:
        """A signal, recorded at any rate, on the even time axis, shape (t, n)."""
        signal = self.recording.signals[name]
        if (
            signal.time.shape == self.time.shape
            and np.max(np.abs(signal.time - self.time)) < 1e-3 / self.rate
        ):
            return np.array(signal.values)
        return signal.at(self.time)

    def motion(self, cutoff: float) -> Motion:
        """Motion low-passed at a cut-off [Hz], including the transients of the filter at both ends."""
        smooth = low_pass(self.position, self.rate, cutoff)
        velocity, acceleration = self._derivatives(smooth, cutoff)
        temperature = self.signal("temperature") if "temperature" in self.recording.signals else None
        payload = self.recording.payload.name if self.recording.payload else ""
        return Motion.of(self.time, smooth, velocity, acceleration, None, temperature, payload)

    def _derivatives(self, smooth: np.ndarray, cutoff: float) -> tuple[np.ndarray, np.ndarray]:
        """Velocity and acceleration, from the recorded velocity if it is consistent with the position.

        A controller counts encoder ticks on its own clock, so jitter of the time stamps does not affect its
        velocity. But the velocity lags behind the position, by half the time over which ticks are counted and
        by the delay of its filter. A lag of a millisecond or two would make inertia look like damping, so the
        lag of each joint is removed first, to first order. The velocity is used if it then differs from the
        differentiated position by less than 5 % on every joint: a velocity of another quantity, unit or
        filter differs by more.
        """
        velocity, acceleration = differentiate(smooth, self.rate)
        if "velocity" not in self.recording.signals:
            return velocity, acceleration
        recorded = low_pass(self.signal("velocity"), self.rate, cutoff)
        slope = differentiate(recorded, self.rate)[0]
        delay = np.sum(slope * (velocity - recorded), axis=0) / np.maximum(np.sum(slope**2, axis=0), 1e-12)
        recorded = recorded + delay * slope
        size = np.maximum(np.linalg.norm(velocity, axis=0), 1e-12)
        if not np.all(np.linalg.norm(recorded - velocity, axis=0) < 0.05 * size):
            return velocity, acceleration
        return recorded, differentiate(recorded, self.rate)[0]


def torque_off(current: np.ndarray, position: np.ndarray, rate: float) -> np.ndarray:
    """Whether a drive was off while its joint moved, such as a released pendulum, bool of shape (t, n).

    Unfiltered currents [A] or torques [N m], and positions [rad], have shape (t, n); the rate is in Hz.
    """
    off = np.zeros(current.shape, bool)
    reach = np.ptp(position, axis=0)
    for joint in range(current.shape[1]):
        zero = (current[:, joint] == 0.0).astype(int)
        edges = np.flatnonzero(np.diff(zero, prepend=0, append=0))
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            moved = np.ptp(position[start:stop, joint])
            off[start:stop, joint] = stop - start >= OFF * rate and moved > MOVED * reach[joint]
    return off


NEAR = 0.01
"""Distance from the largest current within which a sample counts as clipped, as a share of it [-]; it allows
for noise and quantization."""


def is_clipped(model: Model, current: np.ndarray, apart: int) -> np.ndarray:
    """Whether currents (t, n) [A] are at the limit of a sensor in the model, bool of shape (t, n).

    Noise may take single samples below the limit, so gaps of less than `apart` samples count as clipped.
    """
    at_limit = np.abs(current) >= (1.0 - NEAR) * model.current_limit
    return np.asarray(ndimage.binary_closing(at_limit, np.ones((apart, 1))) | at_limit)


def filled(
    model: Model, motion: Motion, current: np.ndarray, gain: np.ndarray, clipped: np.ndarray
) -> np.ndarray:
    """Currents (t, n) [A] in which clipped samples are nominal currents, shifted to match their neighbors.

    Clipped samples have no weight, but the filters of samples with weight extend over them.
    """
    if not np.any(clipped):
        return current
    torque = np.concatenate(
        [columns @ model.nominal_values + known for columns, known in model.pieces(motion)]
    )
    nominal, values = torque @ model.robot.to_motors.T / gain, np.array(current)
    for joint in np.flatnonzero(np.any(clipped, axis=0) & ~np.all(clipped, axis=0)):
        gaps = clipped[:, joint]
        around = (current - nominal)[~gaps, joint]
        shift = np.interp(motion.time[gaps], motion.time[~gaps], around)
        values[gaps, joint] = nominal[gaps, joint] + shift
    return values
