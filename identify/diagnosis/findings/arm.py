"""Arm: a model with values, gains and gears, that can be simulated."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from ...arm.robot import Robot
from ...effects import Effect, RotorInertia
from ...model import Model
from ...simulation.plant import Transmission
from ...simulation.plant.typical import typical_size

LIGHT = 0.01
"""Share of what a joint moves that its motor has where the model gives it no inertia [-]: too little to be
seen in a torque."""


@dataclass(frozen=True, eq=False)
class Arm:
    """An arm that can be simulated."""

    model: Model  # robot and effects
    values: np.ndarray  # its parameters, shape (p,)
    gain: np.ndarray  # its drive gains, shape (n,) [N m/A]
    transmission: Transmission  # what is between motors and links
    left_out: tuple[int, ...] = ()  # findings, by their place, that are no part of it

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

    def with_gear(self, joint: int, stiffness: float, damping: float, play: float) -> "Arm":
        """With one gear that is not rigid; of two findings the softer spring and the wider play.

        Stiffness is in N m/rad, damping in N m s/rad, play the whole width [rad].
        """
        old, place = self.transmission, np.arange(len(self.gain)) == joint
        gears = Transmission(
            np.where(place, np.minimum(old.stiffness, stiffness), old.stiffness),
            np.where(place, np.maximum(old.damping, damping), old.damping),
            np.where(place, np.maximum(old.backlash, play), old.backlash),
        )
        return replace(self._with_rotor(joint), transmission=gears)

    def _with_rotor(self, joint: int) -> "Arm":
        """With a motor that can be moved apart from its link, be the model without rotor inertia."""
        name, effect = f"Ia{joint + 1}", RotorInertia((self.model.robot.joints[joint],))
        if self.by_name.get(name, 0.0) > 0.0:
            return self
        model = self.model if name in self.by_name else self.model + effect
        light = LIGHT * float(typical_size(self.model)[0][joint])
        return replace(self, model=model).with_values({name: light})


def _same_shape(one: Effect, other: Effect) -> bool:
    constants = [one.name for one in fields(other) if one.name != "joints"]
    return type(one) is type(other) and all(getattr(one, name) == getattr(other, name) for name in constants)
