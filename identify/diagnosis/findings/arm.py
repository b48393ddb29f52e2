"""Arm: a model with values and gains, that can be simulated."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from ...arm.robot import Robot
from ...effects import Effect
from ...measurements import Measurement
from ...model import Model


@dataclass(frozen=True, eq=False)
class Arm:
    """An arm that can be simulated."""

    model: Model  # robot and effects
    values: np.ndarray  # its parameters, shape (p,)
    gain: np.ndarray  # its drive gains, shape (n,) [N m/A]
    left_out: tuple[int, ...] = ()  # findings, by their place, that are no part of it
    peak: np.ndarray | None = None  # largest torque of each motor in the runs, shape (n,) [N m]

    @property
    def by_name(self) -> dict[str, float]:
        """Values of the parameters."""
        return dict(zip(self.model.names, map(float, self.values), strict=True))

    def with_effect(self, effect: Effect, more: Mapping[str, float]) -> "Arm | None":
        """With one more effect, or with more of one that is there already, its parameters by name.

        None where the model has it with another shape: it cannot hold both.
        """
        present = {parameter.name for parameter in effect.parameters(self.model.robot)} & set(self.by_name)
        if present and not any(_same_shape(one, effect) for one in self.model.effects):
            return None
        model = self.model if present else self.model + effect
        return replace(self, model=model).with_values(more)

    def with_values(self, more: Mapping[str, float]) -> "Arm":
        """With some parameters larger than they were, and what the model has newly at these values."""
        names = self.model.names
        before = dict(zip(names, self.values, strict=False))  # new effects' names are the last
        values = np.array([before.get(name, 0.0) + more.get(name, 0.0) for name in names])
        return replace(self, values=values)

    def on(self, robot: Robot) -> "Arm":
        """This arm with another robot."""
        return replace(self, model=replace(self.model, robot=robot))

    def with_measurement(self, measurement: Measurement) -> "Arm":
        """This arm with one more thing between it and its recordings; delays of a joint add up."""
        model = self.model
        return replace(self, model=replace(model, measurements=(*model.measurements, measurement)))

    def without(self, measurements: Sequence[Measurement]) -> "Arm":
        """This arm without the first of its measurements, which are these."""
        left = self.model.measurements[len(measurements) :]
        return replace(self, model=replace(self.model, measurements=left))


def _same_shape(one: Effect, other: Effect) -> bool:
    constants = [one.name for one in fields(other) if one.name != "joints"]
    return type(one) is type(other) and all(getattr(one, name) == getattr(other, name) for name in constants)
