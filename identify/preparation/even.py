"""A recording on an even time axis, and its filtered motion."""

from dataclasses import dataclass

import numpy as np

from ..arm.motion import Motion
from ..errors import NotRecorded, RecordingError
from ..recordings.recording import EFFORT, Recording
from .filters import differentiate, low_pass, uniform

FEWEST = 64
"""Samples below which there is no spectrum to choose filters from; no filter fits such a run anyway."""


@dataclass(frozen=True)
class Even:
    """A recording on an even time axis, not yet filtered."""

    recording: Recording
    time: np.ndarray
    position: np.ndarray
    rate: float
    measures: str

    @classmethod
    def of(cls, recording: Recording, rate: float | None) -> "Even":
        signal = recording.signals["position"]
        if len(signal) < FEWEST:
            raise RecordingError(
                f"{recording.name}: only {len(signal)} samples; record at least some seconds"
            )
        # Stamps are whole nanoseconds: they give a rate to mHz only.
        rate = rate or round(1.0 / float(np.median(np.diff(signal.time))), 3)
        time, position = uniform(signal.time, signal.values, rate)
        measures = next((name for name in EFFORT if len(recording.signals.get(name, ()))), "")
        if not measures:
            raise NotRecorded(
                f"{recording.name}: neither motor currents nor torques were recorded; set the controller up "
                "to send them, or put a trace of it beside the run (exidyn import --align)"
            )
        # Where one of the two was not recorded, there is nothing to compare.
        effort = recording.signals[measures].time
        both = (time > effort[0] - 1.5 / rate) & (time < effort[-1] + 1.5 / rate)
        if np.count_nonzero(both) < FEWEST:
            raise RecordingError(
                f"{recording.name}: position and {measures} share only {np.count_nonzero(both)} samples; "
                "are their time stamps from one clock?"
            )
        return cls(recording, time[both], position[both], rate, measures)

    @property
    def gain(self) -> np.ndarray:
        """Nominal torque per unit of what was measured, shape (n,)."""
        known = self.measures == "torque"
        return np.ones(self.position.shape[1]) if known else self.recording.robot.drive_gain

    @property
    def current(self) -> np.ndarray:
        return self.signal(self.measures)

    def signal(self, name: str) -> np.ndarray:
        """A signal of its own rate, on the even time axis."""
        signal = self.recording.signals[name]
        if (
            signal.time.shape == self.time.shape
            and np.max(np.abs(signal.time - self.time)) < 1e-3 / self.rate
        ):
            return np.array(signal.values)
        return np.stack([np.interp(self.time, signal.time, column) for column in signal.values.T], axis=1)


def whole_motion(even: Even, cutoff: float) -> Motion:
    """Motion low-passed at a cut-off [Hz], its ends included."""
    smooth = low_pass(even.position, even.rate, cutoff)
    velocity, acceleration = _derivatives(even, smooth, cutoff)
    temperature = even.signal("temperature") if "temperature" in even.recording.signals else None
    payload = even.recording.payload.name if even.recording.payload else ""
    return Motion.of(even.time, smooth, velocity, acceleration, None, temperature, payload)


def _derivatives(even: Even, smooth: np.ndarray, cutoff: float) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and acceleration; from the controller's own velocity where it can be trusted.

    A controller counts encoder ticks on its own clock, so its velocity knows nothing of the jitter of
    time stamps. But it comes later than the position, by half the time over which they are counted and by
    what its filter takes: a millisecond or two, of which inertia would look like damping. So it is brought
    to the position's time first. It is trusted if it then differs from the differentiated position by less
    than a twentieth on every joint: a velocity of another quantity, unit or filter differs by more.
    """
    velocity, acceleration = differentiate(smooth, even.rate)
    if "velocity" not in even.recording.signals:
        return velocity, acceleration
    recorded = _in_time(low_pass(even.signal("velocity"), even.rate, cutoff), velocity, even.rate)
    apart = np.linalg.norm(recorded - velocity, axis=0) / np.maximum(np.linalg.norm(velocity, axis=0), 1e-12)
    if not np.all(apart < 0.05):
        return velocity, acceleration
    return recorded, differentiate(recorded, even.rate)[0]


def _in_time(recorded: np.ndarray, velocity: np.ndarray, rate: float) -> np.ndarray:
    """A velocity that comes too late, each joint by its own time, to first order in that time."""
    slope = differentiate(recorded, rate)[0]
    delay = np.sum(slope * (velocity - recorded), axis=0) / np.maximum(np.sum(slope**2, axis=0), 1e-12)
    return recorded + delay * slope
