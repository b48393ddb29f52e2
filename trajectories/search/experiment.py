"""Information of a motion on a model's unknowns, and its gradient by the motion.

Unknowns besides linear parameters are effects whose regressor columns are first derivatives. Friction
reversals are made gradual for a search, so that they have a gradient.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.effects import EFFECTS, Effect, MotionGradient, Parameter, Prior
from exidyn.identification.effects.effect import differences
from exidyn.identification.errors import RobotError
from exidyn.identification.fit.base_parameters import BaseParameters, base_parameters, rich_motion
from exidyn.identification.model import Model

from ..errors import NothingToIdentify, UnknownChoice
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


WIDEST = 0.03
"""Largest velocity range over which friction reverses in a design [rad/s]: with a wider one, a search lets
joints creep, as their friction then seems small."""


def design_model(model: Model, limits: Limits, spacing: float) -> Model:
    """The model with every friction reversal as wide as the typical velocity change between samples.

    Friction that reverses within milliradians per second is a step between two samples, with zero gradient
    everywhere else. A row of the equations is a mean over its sampling period, in which friction reverses as
    gradually as here.
    """
    change = 0.5 * float(np.median(limits.acceleration)) * spacing  # half: the mean of a sinusoid
    return _gradual(model, min(change, WIDEST))


def _gradual(model: Model, width: float) -> Model:
    return replace(model, effects=tuple(_gradual_effect(effect, width) for effect in model.effects))


def _gradual_effect(effect: Effect, width: float) -> Effect:
    """An effect, and the effects and models that it contains, with gradual reversals.

    Otherwise a drive gain, whose column is a model's torque, would seem to be identifiable from the
    difference between sharp and gradual friction.
    """
    changed: dict[str, object] = {}
    for name in (field.name for field in fields(effect)):
        part = getattr(effect, name)
        if isinstance(part, Model):
            changed[name] = _gradual(part, width)
        elif isinstance(part, Effect):
            changed[name] = _gradual_effect(part, width)
        elif name == "reversal":
            changed[name] = max(float(part), min(width, effect.shapes()[name].high))
    return replace(effect, **changed)


@dataclass(frozen=True, eq=False)
class DriveGains(Effect):
    """Relative errors of the drive gains: an error of one percent in a gain is one percent in torque.

    In the equations, gain * current = regressor @ values + known torque, the column of a gain is the torque.
    Only a run with a known payload distinguishes it from a common scaling of all parameters.
    """

    model: Model  # model of the nominal torque of the drives

    def parameters(self, robot: Robot) -> list[Parameter]:
        return [Parameter(f"gain{joint + 1}", "1", regroup=2) for joint in range(robot.dof)]

    def priors(self, robot: Robot) -> Mapping[str, Prior]:
        names = [parameter.name for parameter in self.parameters(robot)]
        return {
            name: Prior(0.0, float(std)) for name, std in zip(names, robot.drive_gain_tolerance, strict=True)
        }

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        torque = self.model.torque(self.model.loaded(motion), self.model.nominal_values)
        on_motors = torque @ robot.to_motors.T
        return on_motors[:, None, :] * robot.coupling.T  # back to the joints, drive by drive

    def motion_gradient(
        self, robot: Robot, motion: Motion, weights: np.ndarray, known: np.ndarray
    ) -> MotionGradient:
        joint_weights = np.einsum("tji,ij->ti", weights, robot.coupling) @ robot.to_motors
        values = self.model.nominal_values
        return self.model.motion_gradient(
            self.model.loaded(motion), joint_weights[:, :, None] * values, joint_weights
        )


@dataclass(frozen=True, eq=False)
class ShapesOf(Effect):
    """Shapes of an effect (for example a Stribeck velocity) as unknowns, near their nominal values."""

    effect: Effect  # effect with the shapes
    values: np.ndarray  # nominal values of the effect's parameters, shape (p,)
    label: str  # suffix that makes parameter names unique

    @property
    def needs_load(self) -> bool:  # type: ignore[override]
        """Whether the effect needs the load."""
        return self.effect.needs_load

    def parameters(self, robot: Robot) -> list[Parameter]:
        return [Parameter(f"{name}_{self.label}", s.unit) for name, s in self.effect.shapes().items()]

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        by_shape = self.effect.shape_derivatives(robot, motion)
        return np.stack([by_shape[name] @ self.values for name in self.effect.shapes()], axis=2)

    def motion_gradient(
        self, robot: Robot, motion: Motion, weights: np.ndarray, known: np.ndarray
    ) -> MotionGradient:
        return differences(self.regressor, robot, motion, weights, self.effect.needs_load)


def with_drive_gains(model: Model) -> Model:
    """The model with its drive gains unknown."""
    return model + DriveGains(model)


def with_shapes(model: Model, keys: Sequence[str]) -> Model:
    """The model with the shapes of the named effects unknown, joint by joint where they may differ.

    Raises:
        UnknownChoice: The model has no effect with shapes of that name.
    """
    kinds = {type(effect) for effect in model.effects}
    shaped = [key for key, kind in EFFECTS.items() if kind in kinds and kind.shapes()]
    for key in keys:
        if key not in shaped:
            raise UnknownChoice("effect with shapes in the model", key, shaped or ["none"])
    wanted, out, start = {EFFECTS[key] for key in keys}, model, 0
    for effect in model.effects:
        stop = start + len(effect.parameters(model.robot))
        values = model.nominal_values[start:stop]
        if type(effect) in wanted:
            pieces = effect.apart(model.robot)
            share = len(values) // len(pieces)
            for place, piece in enumerate(pieces):
                piece_values = values[place * share : (place + 1) * share]
                label = piece.parameters(model.robot)[0].name
                out = out + ShapesOf(piece, piece_values, label)
        start = stop
    return out
