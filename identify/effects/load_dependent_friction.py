"""Dry friction that grows with the torque that the gear transmits."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import JointEffect, shape
from .smooth_sign import smooth_sign, smooth_sign_by_reversal


def _pressed(load: Any, preload: float) -> Any:
    """Increase of the contact load over the preload [N m]."""
    return np.hypot(load, preload) - preload


@dataclass(frozen=True)
class LoadDependentFriction(JointEffect):
    r"""Torque :math:`\mu (\sqrt{p^2 + \tau_{load}^2} - p) \tanh(\dot q / v_r)`.

    The load presses on teeth and bearings. A preload p reduces the effect of small loads; the friction
    without load is Coulomb friction.

    The load is `Motion.load`, the nominal torque through the gear. The measured torque would bring its noise,
    and the friction itself, into the column.

    Attributes:
        reversal: Velocity :math:`v_r` over which the sign changes [rad/s].
        preload: Torque that teeth and bearings carry without a load, :math:`p` [N m].
    """

    reversal: float = shape(0.003, "rad/s", 1e-4, 0.1)
    preload: float = 0.0

    needs_load: ClassVar[bool] = True
    greased: ClassVar[bool] = True
    coefficients: ClassVar[tuple[tuple[Any, ...], ...]] = (("mu", "1", 0.0),)

    def profiles(self, at: Any) -> tuple[Any, ...]:
        return (smooth_sign(at.velocity, self.reversal) * _pressed(at.load, self.preload),)

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        slope = smooth_sign_by_reversal(motion.velocity, self.reversal) * _pressed(motion.load, self.preload)
        return {"reversal": self.on_joints(robot, slope)}
