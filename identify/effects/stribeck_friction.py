"""Dry friction that fades as a film of grease builds up."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import Formula, JointEffect, Parameter, shape
from .smooth_sign import smooth_sign, smooth_sign_by_reversal


def _decay(velocity: Any, fade: float, exponent: float) -> Any:
    """Remaining share of the friction at a velocity [-]."""
    return np.exp(-(np.abs(velocity / fade) ** exponent))


def _profiles(position: Any, velocity: Any, load: Any, temperature: Any, constants: Any) -> tuple[Any, ...]:
    return (smooth_sign(velocity, constants[1]) * _decay(velocity, constants[0], constants[2]),)


@dataclass(frozen=True)
class StribeckFriction(JointEffect):
    r"""Torque :math:`F_s \tanh(\dot q / v_r) e^{-|\dot q / v_s|^\delta}`, on top of Coulomb friction.

    The exponent is 1 with Tustin and 2 with Armstrong-Hélouvry; between them, 1.5 is within 5 % of the form
    :math:`1 / (1 + (\dot q / v_s)^2)` of Hess and Soom.

    Attributes:
        fade: Stribeck velocity :math:`v_s`, at which 37 % of the friction remains [rad/s].
        reversal: Velocity :math:`v_r` over which the sign changes [rad/s].
        exponent: Exponent :math:`\delta` [-].
    """

    fade: float = shape(0.1, "rad/s", 0.01, 1.0)
    reversal: float = shape(0.003, "rad/s", 1e-4, 0.1)
    exponent: float = 2.0

    greased: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ("velocity",)

    @property
    def formula(self) -> Formula:
        return Formula(_profiles, (self.fade, self.reversal, self.exponent))

    def parameters(self, robot: Robot) -> list[Parameter]:
        return self.on_each(robot, ("Fs", "N m", 0.0))

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, *self.profiles(motion))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        v, decay = motion.velocity, _decay(motion.velocity, self.fade, self.exponent)
        growth = self.exponent * np.abs(v / self.fade) ** self.exponent / self.fade
        fade = smooth_sign(v, self.reversal) * decay * growth
        reversal = smooth_sign_by_reversal(v, self.reversal) * decay
        return {"fade": self.on_joints(robot, fade), "reversal": self.on_joints(robot, reversal)}
