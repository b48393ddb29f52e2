"""Residual while the arm moves: measured joint torque minus the nominal torque of the measured motion.

The motion's derivatives are those of a quadratic, by least squares through a short window of samples, at the
window's middle: at its end they would be up to date, but the velocity alone would have eight times the noise.
Measured and nominal torque of that moment are then both averaged over a longer window, so that noise and
the moments at which friction reverses do not hide what stays. So what is shown is half of both windows old.
"""

from collections import deque
from typing import Any, NamedTuple

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload

from ..run.arms import with_body

WINDOW = 0.04
"""Time that a quadratic spans [s]; a motion of 8 Hz keeps 90 % of its acceleration."""
AVERAGE = 0.1
"""Time over which torques are averaged [s]: some pixels of a plot."""
FEWEST = 7
"""Samples that either holds at least; slow controllers take longer for them."""
RATE = 50.0
"""Averages a second [Hz]: five a window, and enough for the eye."""
HOLES = 0.6
"""Cycles by which a window may be longer than it should be: a skipped one is a jolt, no quadratic."""
MARKS = 8
"""Steps of a power of ten between lowest and highest value: as many numbers have room beside a plot."""


class Samples(NamedTuple):
    """Samples in order, or windows of them, which have one axis more.

    Attributes:
        stamp: What to call them, shape (t,).
        time: Clock by which they were measured, shape (t,) [s].
        position: Shape (t, n) [rad]; NaN for a joint that was silent.
        torque: Measured joint torque, shape (t, n) [N m]; see `joint_torque`.
    """

    stamp: np.ndarray
    time: np.ndarray
    position: np.ndarray
    torque: np.ndarray


class Torques(NamedTuple):
    """What the arm did and what moved it; NaN where a window has holes.

    Attributes:
        stamp: Stamp of the samples in the middle, shape (r,).
        velocity: Shape (r, n) [rad/s].
        measured: Shape (r, n) [N m].
        nominal: Shape (r, n) [N m].
    """

    stamp: np.ndarray
    velocity: np.ndarray
    measured: np.ndarray
    nominal: np.ndarray

    @property
    def residual(self) -> np.ndarray:
        """What the model does not explain, shape (r, n) [N m]."""
        return self.measured - self.nominal


class LiveResidual:
    """Takes samples of the nominal arm as they come, in pieces of any length, a cycle [s] from each other.

    Attributes:
        delay: Age of the latest torques when the sample comes that completes them [s].
    """

    def __init__(self, model: Model, cycle: float, payload: KnownPayload | None = None) -> None:
        self._model = with_body(model, payload)
        self._payload = payload.name if payload is not None else ""
        self._values = self._model.nominal_values
        self._memory: list[Any] = [None] * len(self._model.effects)
        self._middle, average = (max(round(0.5 * t / cycle), FEWEST // 2) for t in (WINDOW, AVERAGE))
        self._cycle, self._half = cycle, self._middle * cycle
        self.delay = (self._middle + average) * cycle
        self._fitted = _Windows(2 * self._middle + 1, 1)
        self._averaged = _Windows(2 * average + 1, max(round(1.0 / (RATE * cycle)), 1))

    def add(self, samples: Samples) -> Torques:
        """Torques of every window that is whole by now."""
        windows = Samples(*self._fitted.add(samples))
        motion, middle = self._motion(windows), self._middle
        rows = (windows.stamp[:, middle], motion.velocity, windows.torque[:, middle], self._nominal(motion))
        stamp, velocity, measured, nominal = self._averaged.add(rows)
        middle = stamp.shape[1] // 2
        return Torques(stamp[:, middle], velocity[:, middle], measured.mean(axis=1), nominal.mean(axis=1))

    def _motion(self, windows: Samples) -> Motion:
        """Motion in the middle of each window; NaN where that has holes."""
        middle = windows.time[:, self._middle]
        onward = (np.diff(windows.time, axis=1) > 0.0).all(axis=1)
        whole = onward & (windows.time[:, -1] - windows.time[:, 0] < 2.0 * self._half + HOLES * self._cycle)
        usual = np.linspace(-1.0, 1.0, 2 * self._middle + 1)
        time = np.where(whole[:, None], (windows.time - middle[:, None]) / self._half, usual)
        powers = np.stack([np.ones_like(time), time, 0.5 * time**2], axis=2)
        across = np.swapaxes(powers, 1, 2)
        # times lie around zero and are of size one, so that forming the product loses nothing
        fit = np.linalg.solve(across @ powers, across @ windows.position)
        fit[~whole] = np.nan
        position, velocity, acceleration = np.moveaxis(fit, 1, 0)
        return Motion.of(
            middle, position, velocity / self._half, acceleration / self._half**2, payload=self._payload
        )

    def _nominal(self, motion: Motion) -> np.ndarray:
        """The model's torque where all of the arm's motion is known, shape (r, n) [N m]."""
        nominal = np.full_like(motion.position, np.nan)
        known = np.isfinite(motion.position).all(axis=1)
        if known.any():
            time, position = motion.time[known], motion.position[known]
            velocity, acceleration = motion.velocity[known], motion.acceleration[known]
            piece = Motion.of(time, position, velocity, acceleration, payload=self._payload)
            nominal[known] = self._torque(self._model.loaded(piece))
        return nominal

    def _torque(self, piece: Motion) -> np.ndarray:
        """As `Model.torque`, effects with a memory going on from the piece before."""
        remembered = zip(self._model.effects, self._memory, strict=True)
        pieces = [effect.continued(self._model.robot, piece, memory) for effect, memory in remembered]
        self._memory = [memory for _, memory in pieces]
        none = np.zeros((*piece.position.shape, 0))  # of a model without effects
        columns = np.concatenate([none, *(columns for columns, _ in pieces)], axis=2)
        return columns @ self._values + self._model.known_torque(piece)


class _Windows:
    """Rows that come in pieces, cut into windows of some rows that begin every few rows."""

    def __init__(self, size: int, step: int) -> None:
        self._size, self._step = size, step
        self._waiting: list[np.ndarray] = []

    def add(self, rows: tuple[np.ndarray, ...]) -> list[np.ndarray]:
        """Windows (r, size, ...) that are whole by now, of arrays (t, ...)."""
        before = self._waiting or [array[:0] for array in rows]
        all_rows = [np.concatenate(pair) for pair in zip(before, rows, strict=True)]
        count = max((len(all_rows[0]) - self._size) // self._step + 1, 0)
        places = self._step * np.arange(count)[:, None] + np.arange(self._size)
        self._waiting = [array[self._step * count :] for array in all_rows]
        return [array[places] for array in all_rows]


def joint_torque(model: Model, current: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Joint torque by the nominal drive gains; the controller's own where it sends no current.

    All are of shape (t, n), in [A] and [N m]; NaN where there is none. The model has gains and coupling.
    """
    by_current = (current * model.robot.drive_gain) @ model.robot.coupling
    return np.where(np.isnan(by_current), torque, by_current)


class Scale:
    """The power of ten at which an axis of some past [s] is marked, on both sides of zero.

    Rerun numbers an axis without limits at powers of ten, and at zero alone if none is near.
    """

    def __init__(self, past: float) -> None:
        self._past = past
        self._ranges: deque[tuple[float, float, float]] = deque()

    def add(self, time: np.ndarray, values: np.ndarray) -> float:
        """The mark once values (t, n) at times (t,) [s] are shown too; NaN while nothing but NaN is."""
        known = values[np.isfinite(values)]
        if len(known):
            self._ranges.append((float(time[-1]), float(known.min()), float(known.max())))
        while self._ranges and self._ranges[0][0] < time[-1] - self._past:
            self._ranges.popleft()
        _, lowest, highest = np.array(self._ranges).reshape(-1, 3).T
        span = np.ptp([*lowest, *highest, 0.0])
        return float(10.0 ** np.ceil(np.log10(span / MARKS))) if span > 0.0 else float("nan")
