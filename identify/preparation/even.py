"""A recording on an even time axis: its motion, its effort, and where a drive was off."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..arm.derivatives import differentiate
from ..arm.motion import Motion
from ..errors import NotRecorded, RecordingError
from ..recordings.recording import EFFORT, Recording
from .filters import low_pass, uniform
from .undelayed import without_delay

if TYPE_CHECKING:
    from .prepare import Prepared

FEWEST = 64
"""Samples below which there is no spectrum to choose filters from; no filter fits such a run anyway."""
OFF = 0.2
"""Length [s] of a stretch of currents that are zero to the last digit: a drive that moves passes through."""
MOVED = 0.02
"""Share of a joint's range in a run that it moves in such a stretch; at rest, nothing need flow."""


@dataclass(frozen=True)
class Even:
    """A recording on an even time axis, not yet filtered.

    Attributes:
        recording: One run.
        time: Shape (t,) [s].
        position: Shape (t, n) [rad].
        rate: Samples per second [Hz].
        measures: "current" or "torque".
    """

    recording: Recording
    time: np.ndarray
    position: np.ndarray
    rate: float
    measures: str

    @classmethod
    def of(cls, recording: Recording, rate: float | None) -> "Even":
        """Resample where position and effort were both recorded; by default at the median rate [Hz].

        Raises:
            NotRecorded: Neither currents nor torques.
            RecordingError: Too few samples.
        """
        recording = without_delay(recording)
        signal = recording.signals["position"]
        if len(signal) < FEWEST:
            raise RecordingError(
                f"{recording.name}: only {len(signal)} samples; record at least some seconds"
            )
        # Stamps are whole nanoseconds: they give a rate to mHz only.
        rate = rate or round(1.0 / signal.period, 3)
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

    def signal(self, name: str) -> np.ndarray:
        """A signal of its own rate, on the even time axis, shape (t, n)."""
        signal = self.recording.signals[name]
        if (
            signal.time.shape == self.time.shape
            and np.max(np.abs(signal.time - self.time)) < 1e-3 / self.rate
        ):
            return np.array(signal.values)
        return np.stack([np.interp(self.time, signal.time, column) for column in signal.values.T], axis=1)

    def motion(self, cutoff: float) -> Motion:
        """Motion low-passed at a cut-off [Hz], its ends included."""
        smooth = low_pass(self.position, self.rate, cutoff)
        velocity, acceleration = self._derivatives(smooth, cutoff)
        temperature = self.signal("temperature") if "temperature" in self.recording.signals else None
        payload = self.recording.payload.name if self.recording.payload else ""
        return Motion.of(self.time, smooth, velocity, acceleration, None, temperature, payload)

    def _derivatives(self, smooth: np.ndarray, cutoff: float) -> tuple[np.ndarray, np.ndarray]:
        """Velocity and acceleration; from the controller's own velocity where it can be trusted.

        A controller counts encoder ticks on its own clock, so its velocity knows nothing of the jitter of
        time stamps. But it comes later than the position, by half the time over which they are counted and
        by what its filter takes: a millisecond or two, of which inertia would look like damping. So each
        joint's is brought to the position's time first, to first order in that time. It is trusted if it
        then differs from the differentiated position by less than a twentieth on every joint: a velocity of
        another quantity, unit or filter differs by more.
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
    """Whether a drive gave nothing though its joint moved, as of a pendulum let go, bool of shape (t, n).

    Current, or torque, is unfiltered; it and the position [rad] are (t, n).
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


def torque_off_warnings(joints: Sequence[str], runs: Sequence["Prepared"]) -> Iterator[str]:
    """What was left out of runs because a drive was off, in sentences."""
    for run in runs:
        for joint, seconds in zip(joints, run.off, strict=True):
            if seconds > 0.0:
                yield (
                    f"{run.name}: the {run.measures} of {joint} is exactly zero in {seconds:.1f} s in which "
                    "it moves: its drive was off, or measures none that small; those samples are left out"
                )
