"""Arm: a model with values and gains, ready to be simulated."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from ...arm.robot import Robot
from ...effects import Effect
from ...measurements import Measurement
from ...model import Model


@dataclass(frozen=True, eq=False)
class Arm:
    """A model with values for all parameters."""

    model: Model  # robot and effects
    values: np.ndarray  # parameters of the model, shape (p,)
    gain: np.ndarray  # drive gains, shape (n,) [N m/A]
    left_out: tuple[int, ...] = ()  # indices of the findings that the model does not contain
    peak: np.ndarray | None = None  # largest torque of each motor in the runs, shape (n,) [N m]

    @property
    def by_name(self) -> dict[str, float]:
        """Values of the parameters by name."""
        return dict(zip(self.model.names, map(float, self.values), strict=True))

    def with_effect(self, effect: Effect, more: Mapping[str, float]) -> "Arm | None":
        """The arm with an added effect, or with larger parameters of an effect that it already has.

        None if the model has the effect with another shape, since it cannot hold both.
        """
        present = {parameter.name for parameter in effect.parameters(self.model.robot)} & set(self.by_name)
        if present and not any(_same_shape(present_effect, effect) for present_effect in self.model.effects):
            return None
        model = self.model if present else self.model + effect
        return replace(self, model=model).with_values(more)

    def with_values(self, more: Mapping[str, float]) -> "Arm":
        """The arm with these increments of its parameters; new parameters start at zero."""
        names = self.model.names
        before = dict(zip(names, self.values, strict=False))  # names of new effects are the last
        values = np.array([before.get(name, 0.0) + more.get(name, 0.0) for name in names])
        return replace(self, values=values)

    def on(self, robot: Robot) -> "Arm":
        """The arm with another robot."""
        return replace(self, model=replace(self.model, robot=robot))

    def with_measurement(self, measurement: Measurement) -> "Arm":
        """The arm with one more measurement model; delays of a joint add up."""
        model = self.model
        return replace(self, model=replace(model, measurements=(*model.measurements, measurement)))


def _same_shape(effect: Effect, other: Effect) -> bool:
    constants = [field.name for field in fields(other) if field.name != "joints"]
    return type(effect) is type(other) and all(
        getattr(effect, name) == getattr(other, name) for name in constants
    )
