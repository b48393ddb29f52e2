"""Residual while the arm moves: measured joint torque minus the nominal torque of the measured motion.

A quadratic is fitted by least squares to a short window of samples; its derivatives at the middle of the
window are those of the motion. At the end of the window they would be more recent, but the velocity would
have eight times the noise. Measured and nominal torque are then averaged over a longer window, so that
neither noise nor reversals of friction hide lasting residuals. The result is delayed by half of both windows.
"""

from collections import deque
from typing import Any, NamedTuple

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload

from ..run.arms import with_body

WINDOW = 0.04
"""Window of the quadratic [s]; a motion of 8 Hz keeps 90 % of its acceleration."""
AVERAGE = 0.1
"""Averaging window of torques [s]: some pixels of a plot."""
MIN_SAMPLES = 7
"""Minimum number of samples in either window; windows of slow controllers are longer."""
RATE = 50.0
"""Rate of averages [Hz]: five per window, and enough for the eye."""
MAX_GAP = 0.6
"""Maximum excess length of a window [cycles]: a skipped cycle would look like a jolt."""
MARKS = 8
"""Maximum number of marks between lowest and highest value that have room beside a plot."""


class Samples(NamedTuple):
    """Samples in order, or windows of samples, which have an additional axis."""

    stamp: np.ndarray  # time stamps for display, shape (t,)
    time: np.ndarray  # times of measurement, shape (t,) [s]
    position: np.ndarray  # position, shape (t, n) [rad]; NaN for a silent joint
    torque: np.ndarray  # measured joint torque, shape (t, n) [N m]; see `joint_torque`


class Torques(NamedTuple):
    """Velocities and averaged torques; NaN if a window has gaps."""

    stamp: np.ndarray  # time stamps of the samples in the middle, shape (r,)
    velocity: np.ndarray  # velocity, shape (r, n) [rad/s]
    measured: np.ndarray  # measured torque, shape (r, n) [N m]
    nominal: np.ndarray  # nominal torque, shape (r, n) [N m]

    @property
    def residual(self) -> np.ndarray:
        """Measured minus nominal torque, shape (r, n) [N m]."""
        return self.measured - self.nominal


class LiveResidual:
    """Computes residuals of a model from samples one cycle [s] apart, added in pieces of any length."""

    def __init__(self, model: Model, cycle: float, payload: KnownPayload | None = None) -> None:
        self._model = with_body(model, payload)
        self._payload = payload.name if payload is not None else ""
        self._values = self._model.nominal_values
        self._memory: list[Any] = [None] * len(self._model.effects)
        self._middle, average = (max(round(0.5 * t / cycle), MIN_SAMPLES // 2) for t in (WINDOW, AVERAGE))
        self._cycle, self._half = cycle, self._middle * cycle
        self.delay = (self._middle + average) * cycle  # age of the latest torques [s]
        self._fitted = _Windows(2 * self._middle + 1, 1)
        self._averaged = _Windows(2 * average + 1, max(round(1.0 / (RATE * cycle)), 1))

    def add(self, samples: Samples) -> Torques:
        """Add samples; return the torques of all windows completed by them."""
        windows = Samples(*self._fitted.add(samples))
        motion, middle = self._motion(windows), self._middle
        rows = (windows.stamp[:, middle], motion.velocity, windows.torque[:, middle], self._nominal(motion))
        stamp, velocity, measured, nominal = self._averaged.add(rows)
        middle = stamp.shape[1] // 2
        return Torques(stamp[:, middle], velocity[:, middle], measured.mean(axis=1), nominal.mean(axis=1))

    def _motion(self, windows: Samples) -> Motion:
        """Motion in the middle of each window; NaN if the window has gaps."""
        middle = windows.time[:, self._middle]
        increasing = (np.diff(windows.time, axis=1) > 0.0).all(axis=1)
        duration = windows.time[:, -1] - windows.time[:, 0]
        complete = increasing & (duration < 2.0 * self._half + MAX_GAP * self._cycle)
        usual = np.linspace(-1.0, 1.0, 2 * self._middle + 1)
        time = np.where(complete[:, None], (windows.time - middle[:, None]) / self._half, usual)
        powers = np.stack([np.ones_like(time), time, 0.5 * time**2], axis=2)
        across = np.swapaxes(powers, 1, 2)
        # times are centered and of magnitude one, so the normal equations are well conditioned
        fit = np.linalg.solve(across @ powers, across @ windows.position)
        fit[~complete] = np.nan
        position, velocity, acceleration = np.moveaxis(fit, 1, 0)
        return Motion.of(
            middle, position, velocity / self._half, acceleration / self._half**2, payload=self._payload
        )

    def _nominal(self, motion: Motion) -> np.ndarray:
        """Nominal torque, shape (r, n) [N m]; NaN where the motion of any joint is unknown."""
        nominal = np.full_like(motion.position, np.nan)
        known = np.isfinite(motion.position).all(axis=1)
        if known.any():
            time, position = motion.time[known], motion.position[known]
            velocity, acceleration = motion.velocity[known], motion.acceleration[known]
            piece = Motion.of(time, position, velocity, acceleration, payload=self._payload)
            nominal[known] = self._torque(self._model.loaded(piece))
        return nominal

    def _torque(self, piece: Motion) -> np.ndarray:
        """Torque as in `Model.torque`; effects with memory continue from the previous piece."""
        pairs = zip(self._model.effects, self._memory, strict=True)
        pieces = [effect.continued(self._model.robot, piece, memory) for effect, memory in pairs]
        self._memory = [memory for _, memory in pieces]
        empty = np.zeros((*piece.position.shape, 0))  # for a model without effects
        columns = np.concatenate([empty, *(columns for columns, _ in pieces)], axis=2)
        return columns @ self._values + self._model.known_torque(piece)


class _Windows:
    """Cuts rows that come in pieces into windows of `size` rows that begin every `step` rows."""

    def __init__(self, size: int, step: int) -> None:
        self._size, self._step = size, step
        self._pending: list[np.ndarray] = []

    def add(self, rows: tuple[np.ndarray, ...]) -> list[np.ndarray]:
        """Add arrays of rows (t, ...); return the windows (r, size, ...) completed by them."""
        pending = self._pending or [array[:0] for array in rows]
        all_rows = [np.concatenate(pair) for pair in zip(pending, rows, strict=True)]
        count = max((len(all_rows[0]) - self._size) // self._step + 1, 0)
        indices = self._step * np.arange(count)[:, None] + np.arange(self._size)
        self._pending = [array[self._step * count :] for array in all_rows]
        return [array[indices] for array in all_rows]


def joint_torque(model: Model, current: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Joint torque from current and nominal drive gains; without a current, the controller's torque.

    All arrays have shape (t, n), in [A] and [N m], with NaN for missing values.
    """
    by_current = (current * model.robot.drive_gain) @ model.robot.coupling
    return np.where(np.isnan(by_current), torque, by_current)


class Scale:
    """The power of ten at which an axis is marked on both sides of zero, for values of the last `past` [s].

    Rerun labels an axis at powers of ten, and only at zero if none of them is near.
    """

    def __init__(self, past: float) -> None:
        self._past = past
        self._ranges: deque[tuple[float, float, float]] = deque()

    def add(self, time: np.ndarray, values: np.ndarray) -> float:
        """Add values (t, n) at times (t,) [s]; return the mark, or NaN if all values are NaN or zero."""
        known = values[np.isfinite(values)]
        if len(known):
            self._ranges.append((float(time[-1]), float(known.min()), float(known.max())))
        while self._ranges and self._ranges[0][0] < time[-1] - self._past:
            self._ranges.popleft()
        _, lowest, highest = np.array(self._ranges).reshape(-1, 3).T
        span = np.ptp([*lowest, *highest, 0.0])
        return float(10.0 ** np.ceil(np.log10(span / MARKS))) if span > 0.0 else float("nan")
