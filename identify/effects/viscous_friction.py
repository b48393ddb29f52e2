"""Friction proportional to velocity."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import Formula, JointEffect, Parameter
from .simulator_terms import JointTerms


def _profiles(position: Any, velocity: Any, load: Any, temperature: Any, constants: Any) -> tuple[Any, ...]:
    return (velocity,)


@dataclass(frozen=True)
class ViscousFriction(JointEffect):
    r"""Torque :math:`F_v \dot q`, the paper's :math:`Fv_j`."""

    smooth: ClassVar[bool] = True
    linear: ClassVar[bool] = True
    guessed: ClassVar[bool] = True
    greased: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ("velocity",)

    @property
    def formula(self) -> Formula:
        return Formula(_profiles, (0.0,))

    def parameters(self, robot: Robot) -> list[Parameter]:
        return self.on_each(robot, ("Fv", "N m s/rad", 0.0))

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, *self.profiles(motion))

    def portable(self, robot: Robot, values: np.ndarray) -> JointTerms:
        return self.terms(robot, damping=values)
