"""Rollouts: short simulations from recorded states, all windows and several versions of a model at once."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from copy import copy
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ..notebook import optional
from ..robot_files.mjcf_names import enum_of
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
    """Windows of runs, and the errors of versions of joint numbers in them.

    Args:
        simulator: Simulation of the file.
        numbers: Where joint numbers are in its model.
        runs: Recorded runs.
        usual: Usual error of each joint, shape (n,) [rad].
        seconds: Duration of each window [s].
        most: Maximum number of windows.
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
        self._rollout = optional("mujoco.rollout", PURPOSE, "mujoco")
        self._mujoco = optional("mujoco", PURPOSE, "mujoco")
        self._simulator, self._numbers = simulator, numbers
        self._windows = _windows(runs, seconds, most)
        step = simulator.model.opt.timestep
        count = max(round(seconds / step), MOMENTS)
        self._times = step * np.arange(count)
        self._rows = np.linspace(count / MOMENTS, count, MOMENTS).astype(int) - 1
        self._kind = int(enum_of("mjtState", "mjSTATE_FULLPHYSICS"))
        self._states = np.array([simulator.state_at(self._kind, *window) for window in self._windows])
        splines = {id(run): CubicSpline(run.time, run.position) for run in runs}
        after = step * (self._rows + 1)
        self._real = np.array([splines[id(run)](run.time[row] + after) for run, row in self._windows])
        self._usual = usual
        self._data = [self._mujoco.MjData(simulator.model) for _ in range(os.cpu_count() or 1)]

    def __len__(self) -> int:
        return len(self._windows)

    def errors(self, versions: Sequence[np.ndarray], held: bool) -> np.ndarray:
        """Simulated minus recorded positions over the usual ones of each joint, shape (v, w, m, n) [-].

        Args:
            versions: Joint numbers, shape (6, n) each.
            held: Whether commands are held from sample to sample; otherwise they are interpolated.
        """
        models = [self._version(values) for values in versions]
        control = np.concatenate([self._control(values[DELAY], held) for values in versions])
        count = len(self._windows)
        inputs = [model for model in models for _ in range(count)], self._data
        with _quiet(self._mujoco):
            states, _ = self._rollout.rollout(
                *inputs, np.tile(self._states, (len(models), 1)), control,
                control_spec=self._simulator.control_spec,
            )  # fmt: skip
        places = 1 + np.array(self._simulator.qpos)  # time is first
        position = states[:, self._rows][:, :, places].reshape(len(models), *self._real.shape)
        position[~np.logical_and.accumulate(np.abs(position) < BEYOND, axis=2)] = BEYOND
        return np.clip((position - self._real) / self._usual, -DIVERGED, DIVERGED)

    def _version(self, values: np.ndarray) -> object:
        model = copy(self._simulator.model)
        self._numbers.set(model, values)
        self._mujoco.mj_setConst(model, self._data[0])
        return model

    def _control(self, delay: np.ndarray, held: bool) -> np.ndarray:
        """Inputs in every step of each window, shape (w, k, u)."""
        simulator = self._simulator
        control = np.zeros((len(self._windows), len(self._times), simulator.input_size))
        for row, (run, first) in zip(control, self._windows, strict=True):
            moments = run.time[first] + self._times
            row[:, simulator.inputs] = simulator.inputs_at(run, moments, delay, held)
        return control


@contextmanager
def _quiet(mujoco: Any) -> Iterator[None]:
    """No warnings of MuJoCo, on the terminal and in a file: some versions that are tried diverge."""
    handler = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(handler)


def _windows(runs: Sequence[Run], seconds: float, most: float) -> list[tuple[Run, int]]:
    """Runs, and the first sample of each window, evenly spaced over all runs."""
    total = sum(max(float(run.time[-1] - run.time[0]) - seconds, 0.0) for run in runs)
    spacing, chosen = max(total / most, 0.5 * seconds), []
    for run in runs:
        moments = np.arange(run.time[0], run.time[-1] - seconds, spacing)
        chosen += [(run, int(first)) for first in np.searchsorted(run.time, moments)]
    return [(run, first) for run, first in chosen if run.time[first] + seconds <= run.time[-1]]
