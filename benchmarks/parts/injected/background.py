"""A real arm's runs as the background: their motion, the load of their gears, what a plain model leaves."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import signal

from exidyn.identification.arm.motion import Motion
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording, Signal

from ..diagnose_real.sets import Runs

SMOOTH = 8.0
"""Cut-off of positions before they are differentiated [Hz]: motion is slower."""
COARSE = 25.0
"""Rows a second of the least squares that gives loads and visibility."""
STILL = 0.02
"""Share of the usual speed below which a joint's rows do not count."""


@dataclass(frozen=True, eq=False)
class Background:
    """The runs of one set."""

    model: Model  # Nominal model of the set
    runs: Runs  # Role and recording

    @cached_property
    def motions(self) -> list[Motion]:
        """Motion of each run at the time stamps of its positions."""
        return [_motion(run) for _, run in self.runs]

    @cached_property
    def torques(self) -> list[np.ndarray]:
        """Measured joint torque of each run at the same time stamps, (t, n) [N m]."""
        return [
            _at(run.signals[effort(run)], motion.time) * self.per_unit(run)
            for (_, run), motion in zip(self.runs, self.motions, strict=True)
        ]

    def per_unit(self, run: Recording) -> np.ndarray:
        """Torque per unit of what was measured, shape (n,); one where a gain is not stated."""
        gain = np.asarray(self.model.robot.drive_gain, float)
        stated = effort(run) == "current" and np.all(np.isfinite(gain)) and np.all(gain != 0.0)
        return gain if stated else np.ones(self.model.robot.dof)

    @cached_property
    def fit(self) -> tuple[np.ndarray, list[np.ndarray]]:
        """Least-squares values of the nominal model's columns, and its regressor of each run, coarse."""
        columns = [self.model.regressor(motion[:: self._step(motion)]) for motion in self.motions]
        left, right = [], []
        for regressor, torque, motion in zip(columns, self.torques, self.motions, strict=True):
            weight = self._moves(motion)
            left.append((regressor * weight[:, :, None]).reshape(-1, regressor.shape[2]))
            right.append((_coarse(torque, motion, self._step(motion)) * weight).ravel())
        values = np.linalg.lstsq(np.concatenate(left), np.concatenate(right), rcond=1e-8)[0]
        return values, columns

    @cached_property
    def loads(self) -> list[np.ndarray]:
        """Torque that the gears transmit, (t, n) [N m]."""
        gears = replace(self.model, effects=tuple(e for e in self.model.effects if e.transmitted))
        own = [c for e, c in zip(self.model.effects, self.model.columns, strict=True) if e.transmitted]
        values = np.concatenate([self.fit[0][c] for c in own])
        return [gears.regressor(motion) @ values for motion in self.motions]

    @cached_property
    def residual(self) -> np.ndarray:
        """Root mean square of what the least squares leave on each joint, shape (n,) [N m]."""
        return self._rms([self._left(torque, place) for place, torque in enumerate(self.torques)])

    def visible(self, added: list[np.ndarray]) -> float:
        """Torque (t, n) of each run that no values of the nominal model explain, over the residual [-]."""
        flat = [
            (regressor * (self._moves(motion) / self.residual)[:, :, None]).reshape(-1, regressor.shape[2])
            for regressor, motion in zip(self.fit[1], self.motions, strict=True)
        ]
        coarse = [
            _coarse(torque, motion, self._step(motion)) * self._moves(motion) / self.residual
            for torque, motion in zip(added, self.motions, strict=True)
        ]
        matrix, vector = np.concatenate(flat), np.concatenate([one.ravel() for one in coarse])
        left = vector - matrix @ np.linalg.lstsq(matrix, vector, rcond=1e-8)[0]
        by_joint = left.reshape(-1, self.model.robot.dof)
        return float(np.sqrt(np.mean(by_joint**2, axis=0)).max())

    def _left(self, torque: np.ndarray, place: int) -> np.ndarray:
        values, columns = self.fit
        motion = self.motions[place]
        left = _coarse(torque, motion, self._step(motion)) - columns[place] @ values
        return left * self._moves(motion)

    def _rms(self, rows: list[np.ndarray]) -> np.ndarray:
        weights = np.concatenate([self._moves(motion) for motion in self.motions])
        return np.sqrt(np.sum(np.concatenate(rows) ** 2, axis=0) / np.maximum(weights.sum(axis=0), 1.0))

    def _step(self, motion: Motion) -> int:
        return max(int(_rate(motion.time) / COARSE), 1)

    def _moves(self, motion: Motion) -> np.ndarray:
        usual = np.sqrt(np.mean(motion.velocity**2, axis=0))
        return (np.abs(motion.velocity[:: self._step(motion)]) > STILL * usual).astype(float)


def effort(run: Recording) -> str:
    """Which signal of a run stands for its torque."""
    return "current" if "current" in run.signals else "torque"


def _rate(time: np.ndarray) -> float:
    return 1.0 / float(np.median(np.diff(time)))


def _at(one: Signal, time: np.ndarray) -> np.ndarray:
    return np.stack([np.interp(time, one.time, column) for column in one.values.T], axis=1)


def _coarse(torque: np.ndarray, motion: Motion, step: int) -> np.ndarray:
    """Low-passed and thinned."""
    rate = _rate(motion.time)
    sections = signal.butter(4, min(0.4 * rate / step, 0.45 * rate), fs=rate, output="sos")
    return signal.sosfiltfilt(sections, torque, axis=0)[::step]


def _motion(run: Recording) -> Motion:
    position = run.signals["position"]
    rate = _rate(position.time)
    sections = signal.butter(4, min(SMOOTH, 0.4 * rate), fs=rate, output="sos")
    smooth = signal.sosfiltfilt(sections, position.values, axis=0)
    velocity = np.gradient(smooth, position.time, axis=0)
    acceleration = np.gradient(velocity, position.time, axis=0)
    payload = run.payload.name if run.payload else ""
    return Motion.of(position.time, smooth, velocity, acceleration, payload=payload)
