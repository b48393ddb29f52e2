"""Inertia of rotor and gear, reflected to the joint."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import JointEffect, Parameter
from .joint_state import JointState, Scalar
from .simulator_terms import JointTerms


@dataclass(frozen=True)
class RotorInertia(JointEffect):
    r"""Torque :math:`I_a \ddot q`, the paper's :math:`Ia_j`: rotor inertia times gear ratio squared."""

    smooth: ClassVar[bool] = True
    linear: ClassVar[bool] = True
    massless: ClassVar[bool] = False
    inertial: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ("acceleration",)

    def parameters(self, robot: Robot) -> list[Parameter]:
        return self.on_each(robot, ("Ia", "kg m^2", 0.0))

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, motion.acceleration)

    def joint_torque(self, robot: Robot, values: np.ndarray, state: JointState) -> Sequence[Scalar]:
        return self.on_scalars(robot, values, lambda joint: (state.acceleration[joint],))

    def portable(self, robot: Robot, values: np.ndarray) -> JointTerms:
        return self.terms(robot, armature=values)
