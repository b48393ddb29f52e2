"""Dry friction: constant torque against the motion."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import Formula, JointEffect, Parameter, shape
from .simulator_terms import JointTerms
from .smooth_sign import smooth_sign, smooth_sign_by_reversal


def _profiles(position: Any, velocity: Any, load: Any, temperature: Any, constants: Any) -> tuple[Any, ...]:
    return (smooth_sign(velocity, constants[0]),)


@dataclass(frozen=True)
class CoulombFriction(JointEffect):
    r"""Torque :math:`F_c \tanh(\dot q / v_r)`, the paper's :math:`Fc_j`.

    Attributes:
        reversal: Velocity :math:`v_r` over which the sign changes [rad/s]; grease that drags like a fluid
            until it shears needs some tenths.
        gradual: Whether it is the part :math:`Fg_j` of a joint's dry friction that changes its sign over
            another velocity than :math:`Fc_j`, so that one model can have both.
    """

    reversal: float = shape(0.003, "rad/s", 1e-4, 0.3)
    gradual: bool = False

    guessed: ClassVar[bool] = True
    dry: ClassVar[bool] = True
    greased: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ("velocity",)

    @property
    def formula(self) -> Formula:
        return Formula(_profiles, (self.reversal,))

    def parameters(self, robot: Robot) -> list[Parameter]:
        return self.on_each(robot, ("Fg" if self.gradual else "Fc", "N m", 0.0))

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, *self.profiles(motion))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        slope = smooth_sign_by_reversal(motion.velocity, self.reversal)
        return {"reversal": self.on_joints(robot, slope)}

    def portable(self, robot: Robot, values: np.ndarray) -> JointTerms:
        return self.terms(robot, dry=values, reversal=np.full(len(values), self.reversal))
