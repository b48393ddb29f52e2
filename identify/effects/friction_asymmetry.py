"""Friction that differs between the two directions."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import Formula, JointEffect, Parameter, shape
from .smooth_sign import smooth_sign, smooth_sign_by_reversal


def _dry(position: Any, velocity: Any, load: Any, temperature: Any, constants: Any) -> tuple[Any, ...]:
    return (np.abs(smooth_sign(velocity, constants[0])),)


def _with_drag(position: Any, velocity: Any, load: Any, temperature: Any, constants: Any) -> tuple[Any, ...]:
    return np.abs(smooth_sign(velocity, constants[0])), np.abs(velocity)


@dataclass(frozen=True)
class FrictionAsymmetry(JointEffect):
    r"""Torque :math:`F_a |\tanh(\dot q / v_r)| + F_{va} |\dot q|`, the even part of friction.

    With `CoulombFriction`, the friction of the joint is :math:`F_c + F_a` forward and :math:`F_c - F_a`
    backward, and with different viscous friction also :math:`F_v \pm F_{va}`. Unlike a `CurrentOffset`, it is
    zero at standstill; a motion without standstill hardly distinguishes the two.

    Attributes:
        reversal: Velocity :math:`v_r` over which the friction builds up [rad/s].
        viscous: Whether viscous friction differs too.
    """

    reversal: float = shape(0.003, "rad/s", 1e-4, 0.1)
    viscous: bool = False

    guessed: ClassVar[bool] = True
    greased: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ("velocity",)

    @property
    def formula(self) -> Formula:
        return Formula(_with_drag if self.viscous else _dry, (self.reversal,))

    def parameters(self, robot: Robot) -> list[Parameter]:
        return self.on_each(robot, *[("Fa", "N m"), ("Fva", "N m s/rad")][: 1 + self.viscous])

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, *self.profiles(motion))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        slope = smooth_sign_by_reversal(motion.velocity, self.reversal)
        still = np.zeros_like(slope)
        columns = [np.sign(motion.velocity) * slope, still][: 1 + self.viscous]
        return {"reversal": self.on_joints(robot, *columns)}
