"""A constant torque: offset of the current amplifier and even part of dry friction."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import Formula, JointEffect, Parameter
from .simulator_terms import JointTerms


def _profiles(position: Any, velocity: Any, load: Any, temperature: Any, constants: Any) -> tuple[Any, ...]:
    return (0.0 * velocity + 1.0,)


@dataclass(frozen=True)
class CurrentOffset(JointEffect):
    r"""Constant torque, the paper's :math:`\tau_{off_j}`."""

    smooth: ClassVar[bool] = True
    linear: ClassVar[bool] = True
    guessed: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ()

    @property
    def formula(self) -> Formula:
        return Formula(_profiles, (0.0,))

    def parameters(self, robot: Robot) -> list[Parameter]:
        return self.on_each(robot, ("Off", "N m"))

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, *self.profiles(motion))

    def portable(self, robot: Robot, values: np.ndarray) -> JointTerms:
        return self.terms(robot, constant=values)
