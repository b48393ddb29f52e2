"""The model that a search uses: unknowns besides linear parameters, and friction reversals with a gradient.

Such unknowns are effects whose regressor columns are first derivatives.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.effects import EFFECTS, Effect, MotionGradient, Parameter, Prior
from exidyn.identification.effects.effect import differences
from exidyn.identification.model import Model

from ..errors import UnknownChoice

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
