"""Rollouts: short simulations from recorded states, all windows and several versions of a model at once."""

from collections.abc import Sequence
from copy import copy

import numpy as np
from scipy.interpolate import CubicSpline

from ..notebook import optional
from .callbacks import PURPOSE
from .joint_numbers import DELAY, JointNumbers
from .replay import BEYOND, Run, Simulator

SECONDS = 1.0
"""Duration of a window [s]: long enough for friction to show, short enough for errors to stay small."""
MOST = 32
"""Maximum number of windows in all runs: it leaves rms errors uncertain by an eighth."""
MOMENTS = 8
"""Moments in a window at which positions are compared."""
DIVERGED = 10.0
"""Largest error that counts, relative to the usual one of a joint."""


class Rollouts:
    """Windows of runs, each of some seconds, and the errors of versions of joint numbers in them.

    Errors are relative to the usual one of each joint (n,) [rad]; there are at most `most` windows.
    """

    def __init__(
        self,
        simulator: Simulator,
        numbers: JointNumbers,
        runs: Sequence[Run],
        usual: np.ndarray,
        seconds: float = SECONDS,
        most: float = MOST,
    ) -> None:
        self._mujoco = optional("mujoco", PURPOSE, "mujoco")
        self._simulator, self._numbers = simulator, numbers
        self._windows = _windows(runs, seconds, most)
        step = simulator.model.opt.timestep
        count = max(round(seconds / step), MOMENTS)
        self._times = step * np.arange(count)
        self._rows = np.linspace(count / MOMENTS, count, MOMENTS).astype(int) - 1
        self._states = np.array([simulator.state_at(*window) for window in self._windows])
        splines = {id(run): CubicSpline(run.time, run.position) for run in runs}
        after = step * (self._rows + 1)
        self._real = np.array([splines[id(run)](run.time[row] + after) for run, row in self._windows])
        self._usual = usual
        self._data = self._mujoco.MjData(simulator.model)

    def __len__(self) -> int:
        return len(self._windows)

    def errors(self, versions: Sequence[np.ndarray], held: bool) -> np.ndarray:
        """Simulated minus recorded positions over the usual ones of each joint, shape (v, w, m, n) [-].

        Versions are joint numbers (6, n); commands are held from sample to sample, or else interpolated.
        """
        models = [copy(self._simulator.model) for _ in versions]
        for model, values in zip(models, versions, strict=True):
            self._numbers.set(model, values)
            self._mujoco.mj_setConst(model, self._data)
        # Inputs in every step of each window, version by version.
        inputs_at, count = self._simulator.inputs_at, len(self._windows)
        inputs = np.array(
            [
                inputs_at(run, run.time[row] + self._times, values[DELAY], held)
                for values in versions
                for run, row in self._windows
            ]
        )
        position = self._simulator.rolled(
            [model for model in models for _ in range(count)], np.tile(self._states, (len(models), 1)), inputs
        )[:, self._rows].reshape(len(models), *self._real.shape)
        position[~np.logical_and.accumulate(np.abs(position) < BEYOND, axis=2)] = BEYOND
        return np.clip((position - self._real) / self._usual, -DIVERGED, DIVERGED)


def _windows(runs: Sequence[Run], seconds: float, most: float) -> list[tuple[Run, int]]:
    """Runs, and the first sample of each window, evenly spaced over all runs."""
    total = sum(max(float(run.time[-1] - run.time[0]) - seconds, 0.0) for run in runs)
    spacing, chosen = max(total / most, 0.5 * seconds), []
    for run in runs:
        moments = np.arange(run.time[0], run.time[-1] - seconds, spacing)
        chosen += [(run, int(first)) for first in np.searchsorted(run.time, moments)]
    return [(run, first) for run, first in chosen if run.time[first] + seconds <= run.time[-1]]
