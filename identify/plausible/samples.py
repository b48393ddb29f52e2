"""Logs prepared for the check: low-passed, decimated, with the motion of the joints."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..arm.motion import Motion, differentiate
from ..arm.robot import Robot
from ..preparation.filters import low_pass, uniform
from ..recordings.recording import EFFORT, Recording

FEWEST = 100
"""Minimum number of samples of a recording."""
CUTOFF = 5.0
"""Low-pass of positions and efforts [Hz]: arms move below it."""
RATE = 100.0
"""Sampling rate at which motions are differentiated [Hz]."""
MOST = 1500
"""Maximum number of samples; more of them add no information."""
SLIDES = 0.03
"""Share of a joint's usual speed below which it may stick, so that the sign of friction is unknown."""
HOLDS = 0.01
"""Share of the fastest joint's usual speed below which a joint stands still and its motion is noise."""
LONG = 1000.0
"""Gap between two runs, in median sampling periods."""
MODEL_ERRORS = 20
"""Maximum number of independent pieces of an effort. Undescribed torque (cables, gears, friction) depends on
pose and direction: it repeats whenever these return, so a longer log does not average it out."""


class Sampled(NamedTuple):
    """A low-passed and decimated log."""

    motion: Motion  # motion of the joints, t samples
    effort: np.ndarray  # efforts in the unit of the log, shape (t, n)
    sliding: np.ndarray  # whether each joint slides, bool of shape (t, n)

    @property
    def pieces(self) -> np.ndarray:
        """Number of independent pieces of each effort, shape (n,)."""
        return np.array([independent(self.effort[rows, j]) for j, rows in enumerate(self.sliding.T)])

    @property
    def moving(self) -> np.ndarray:
        """Whether each joint moves, bool of shape (n,)."""
        return np.asarray(self.sliding.any(axis=0))

    def rows(self, rows: slice) -> "Sampled":
        """Log with some of its samples."""
        return Sampled(self.motion[rows], self.effort[rows], self.sliding[rows])

    def thinned(self, most: int) -> "Sampled":
        """Log with at most `most` samples, evenly spaced."""
        return self.rows(slice(None, None, max(1, -(-len(self.effort) // most))))


def joined(logs: Sequence[Sampled]) -> Sampled:
    """Concatenation of several logs."""
    motions = [log.motion for log in logs]
    time, position, velocity, acceleration = (
        np.concatenate([getattr(motion, name) for motion in motions])
        for name in ("time", "position", "velocity", "acceleration")
    )
    payloads = {motion.payload for motion in motions}
    # The weight of a payload that only some runs carry cannot be told from the bodies of the arm here.
    payload = motions[0].payload if len(payloads) == 1 else ""
    motion = Motion.of(time, position, velocity, acceleration, payload=payload)
    effort, sliding = (np.concatenate([log[place] for log in logs]) for place in (1, 2))
    return Sampled(motion, effort, sliding)


def runs_of(time: np.ndarray) -> list[slice]:
    """Rows of each run of a log, separated by the long gaps in its time (t,)."""
    steps = np.diff(time)
    ends = [0, *(np.flatnonzero(steps > LONG * np.median(steps)) + 1).tolist(), len(time)]
    return [slice(start, end) for start, end in pairwise(ends)]


def sampled(time: np.ndarray, position: np.ndarray, effort: np.ndarray) -> Sampled:
    """Motion and effort at the same samples, from increasing time (t,) [s], positions and efforts (t, n)."""
    rate = min(RATE, 1.0 / float(np.median(np.diff(time))))
    runs, n = runs_of(time), position.shape[1]
    seconds = sum(time[run][-1] - time[run][0] for run in runs)
    step = max(1, int(np.ceil(rate * seconds / MOST)))
    parts = [_smooth(time[run], np.hstack([position[run], effort[run]]), rate, step) for run in runs]
    even, smooth, velocity, acceleration = (np.concatenate(part) for part in zip(*parts, strict=True))
    motion = Motion.of(even, smooth[:, :n], velocity[:, :n], acceleration[:, :n])
    usual = np.percentile(np.abs(motion.velocity), 90, axis=0)
    return Sampled(motion, smooth[:, n:], sliding(motion.velocity) & (usual > HOLDS * usual.max()))


def sliding(velocity: np.ndarray) -> np.ndarray:
    """Whether each joint slides at velocities (t, n), bool of shape (t, n)."""
    return np.asarray(np.abs(velocity) > SLIDES * np.percentile(np.abs(velocity), 90, axis=0))


def independent(values: np.ndarray) -> int:
    """Number of independent pieces of values (t,): crossings of the mean, from 1 to `MODEL_ERRORS`."""
    crossings = int(np.sum(np.diff(np.signbit(values - values.mean())))) if len(values) else 1
    return min(max(1, crossings), MODEL_ERRORS)


def _smooth(time: np.ndarray, values: np.ndarray, rate: float, step: int) -> tuple[np.ndarray, ...]:
    """Low-passed run at every `step`-th uniform sample: time, values, first and second derivative."""
    even, values = uniform(time, values, rate)
    smooth = low_pass(values, rate, min(CUTOFF, 0.2 * rate))
    end = min(len(even) // 4, int(rate / CUTOFF) + 3)
    inside = slice(end, len(even) - end, step)
    return even[inside], smooth[inside], *(values[inside] for values in differentiate(smooth, rate))


def sampled_torques(runs: Sequence[Recording], robot: Robot) -> tuple[list[Recording], list[Sampled], bool]:
    """Usable recordings, their logs, and whether the efforts are torques according to the stated gains."""
    usable = [(run, log) for run, log in ((run, sampled_run(run)) for run in runs) if log is not None]
    torques = {"torque" in run.signals for run, _ in usable}
    gain = robot.drive_gain
    stated = len(torques) == 1 and (torques == {True} or not np.all(gain == 1.0))
    factor = gain if stated and torques == {False} else np.ones(robot.dof)
    logs = [log._replace(effort=log.effort * factor) for _, log in usable]
    return [run for run, _ in usable], logs, stated


def sampled_run(run: Recording) -> Sampled | None:
    """Positions and efforts of a recording at the same samples; None if there are too few."""
    name = next((name for name in EFFORT if name in run.signals), "")
    if not name or min(len(run.signals["position"]), len(run.signals[name])) < FEWEST:
        return None
    position, effort = run.signals["position"], run.signals[name]
    known = np.isfinite(position.values).all(axis=1)
    time = position.time[known]
    efforts = effort.at(time)
    if not np.isfinite(efforts).all() or np.any(np.diff(time) <= 0.0):
        return None
    log = sampled(time, position.values[known], efforts)
    payload = run.payload.name if run.payload else ""
    return log._replace(motion=replace(log.motion, payload=payload))
