"""Information of a motion on a model's unknowns, and its gradient by the motion."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import MotionGradient
from exidyn.identification.errors import RobotError
from exidyn.identification.fit.base_parameters import BaseParameters, base_parameters, rich_motion
from exidyn.identification.model import Model

from ..errors import NothingToIdentify
from ..random_motion import random_fourier

MOTIONS = 4
"""Number of random motions for column sizes: a joint's rms velocity varies by up to 20 % between them, and so
by 10 % in their mean."""
DURATION = 16.0
"""Duration of a random motion [s]: rests, ramps, and one period of 10 s between them."""
AT_FULL_RATE = np.linspace(3.0, 13.0, 100, endpoint=False)
"""Sample times within that period [s]."""


@dataclass(frozen=True, eq=False)
class Experiment:
    """The unknowns of a model that a motion identifies, in runs with different payloads.

    Rows are motor torques times gear ratio, as in `identify.equations`: for a coupled wrist they mix the
    joint torques.
    """

    model: Model  # robot and effects
    base: BaseParameters  # base parameters of the model over all runs
    payloads: tuple[str, ...]  # payload in each run of the same motion; empty for none
    noise: np.ndarray  # standard deviation of each drive's torque, shape (n,) [N m]
    known: np.ndarray  # information on the base parameters from earlier runs or priors, shape (b, b)

    @classmethod
    def of(
        cls,
        model: Model,
        payloads: Sequence[str] = ("",),
        noise: np.ndarray | None = None,
        known: np.ndarray | None = None,
    ) -> "Experiment":
        """The experiment that identifies a model's base parameters.

        Raises:
            NothingToIdentify: No parameter of the model affects a joint torque.
        """
        try:
            base = base_parameters(model, payloads)
        except RobotError as error:
            raise NothingToIdentify(str(error)) from error
        count = len(base.kept)
        noise = np.ones(model.robot.dof) if noise is None else np.asarray(noise, float)
        return cls(model, base, tuple(payloads), noise, np.zeros((count, count)) if known is None else known)

    @cached_property
    def sizes(self) -> np.ndarray:
        """Unit of each base parameter, shape (b,).

        It is the root sum square of the nominal value and the prior's standard deviation. Without a prior, it
        is the value whose torque in a rich motion equals the noise.
        """
        model, base = self.model, self.base
        tolerance = np.array([prior.std for prior in model.priors])
        entering = base.regrouping != 0
        deviation = np.sqrt(np.sum((np.where(entering, tolerance, 0.0) * base.regrouping) ** 2, axis=1))
        size = np.hypot(base.regrouping @ model.nominal_values, deviation)
        runs = self._columns(rich_motion(model, payload=self.payloads[-1]))
        noise = 1.0 / np.sqrt(np.max([np.mean(np.sum(run**2, axis=1), axis=0) for run in runs], axis=0))
        return np.where(np.isfinite(size) & (size > 0), size, noise)

    def column_rms(self, limits: Limits) -> np.ndarray:
        """Size of each base column in random motions within limits, shape (b,).

        It is the root of the mean over samples of the sum of squares over joints and runs, in units of the
        noise.
        """
        motions = [random_fourier(limits, DURATION, seed=seed).at(AT_FULL_RATE) for seed in range(MOTIONS)]
        runs = np.concatenate([run for motion in motions for run in self._columns(motion)])
        return np.sqrt(np.sum(runs**2, axis=(0, 1)) / (MOTIONS * len(AT_FULL_RATE)))

    def columns(self, motion: Motion) -> list[np.ndarray]:
        """Base regressor of each run in units of its noise, each (t, n, b).

        Those of the last motion are cached, since the criteria of an experiment use them in turn.
        """
        if self._last.get("motion") is not motion:
            self._last.update(motion=motion, columns=self._columns(motion))
        columns: list[np.ndarray] = self._last["columns"]
        return columns

    def _columns(self, motion: Motion) -> list[np.ndarray]:
        rows = whitening(self.model, self.noise)
        runs = loaded_runs(self.model, motion, self.payloads)
        return [rows @ self.model.regressor(run)[:, :, self.base.kept] for run in runs]

    @cached_property
    def _last(self) -> dict[str, Any]:
        return {}

    def information(self, motion: Motion, share: float = 1.0) -> np.ndarray:
        """Information after runs of a motion, shape (b, b), each sample counted `share` times."""
        rows = [run.reshape(-1, run.shape[2]) for run in self.columns(motion)]
        return self.known + share * sum(run.T @ run for run in rows)

    def pull(self, motion: Motion, by: np.ndarray, share: float) -> MotionGradient:
        """Gradient of a function of the information by the motion, from its derivative `by` it, (b, b)."""
        total, rows = MotionGradient.none(motion.position.shape), whitening(self.model, self.noise)
        runs = loaded_runs(self.model, motion, self.payloads)
        for run, seen in zip(runs, self.columns(motion), strict=True):
            weights = np.zeros((*motion.position.shape, len(self.model.names)))
            weights[:, :, self.base.kept] = 2.0 * share * rows.T @ (seen @ by)
            total = total + self.model.motion_gradient(run, weights)
        return total


def loaded_runs(model: Model, motion: Motion, payloads: Sequence[str]) -> list[Motion]:
    """The motion with each payload, with gear loads from the model."""
    return [model.loaded(replace(motion, payload=payload)) for payload in payloads]


def whitening(model: Model, noise: np.ndarray) -> np.ndarray:
    """Matrix from joint torques to drive torques over their noise, shape (n, n) [1 / N m].

    For a coupled wrist, the torque of a drive is a mixture of joint torques.
    """
    return model.robot.to_motors / noise[:, None]
