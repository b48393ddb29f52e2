"""Friction that grows faster or slower than velocity: churning or shear-thinning grease."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import Formula, JointEffect, Parameter, shape

TINY = np.finfo(float).tiny  # keeps log and powers finite at standstill, where both products vanish


def _profiles(position: Any, velocity: Any, load: Any, temperature: Any, constants: Any) -> tuple[Any, ...]:
    return (np.sign(velocity) * np.abs(velocity) ** constants[0],)


@dataclass(frozen=True)
class NonlinearViscousFriction(JointEffect):
    r"""Torque :math:`F_n\, \mathrm{sign}(\dot q)\, |\dot q / v_1|^a` with :math:`v_1` = 1 rad/s.

    The reference velocity makes the parameter a torque for any exponent. Exponent 1 is `ViscousFriction`,
    whose column is then the same, so an exponent near 1 means that there is no nonlinearity. Toward 0, the
    effect approaches `CoulombFriction`.

    Attributes:
        exponent: The power :math:`a` of the velocity [-]; 2 is the drag of a stirred fluid.
    """

    exponent: float = shape(2.0, "1", 0.3, 3.0)

    greased: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ("velocity",)

    @property
    def formula(self) -> Formula:
        return Formula(_profiles, (self.exponent,))

    def parameters(self, robot: Robot) -> list[Parameter]:
        return self.on_each(robot, ("Fn", "N m", 0.0))

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, *self.profiles(motion))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        slope = self.profiles(motion)[0] * np.log(np.maximum(np.abs(motion.velocity), TINY))
        return {"exponent": self.on_joints(robot, slope)}
