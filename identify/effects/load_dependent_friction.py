"""Dry friction that grows with the torque that the gear transmits."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import Formula, JointEffect, Parameter, shape
from .smooth_sign import smooth_sign, smooth_sign_by_reversal


def _pressed(load: Any, preload: float) -> Any:
    """By what the load presses more than the preload does alone [N m]."""
    return np.hypot(load, preload) - preload


def _profiles(position: Any, velocity: Any, load: Any, temperature: Any, constants: Any) -> tuple[Any, ...]:
    return (smooth_sign(velocity, constants[0]) * _pressed(load, constants[1]),)


@dataclass(frozen=True)
class LoadDependentFriction(JointEffect):
    r"""Torque :math:`\mu (\sqrt{p^2 + \tau_{load}^2} - p) \tanh(\dot q / v_r)`.

    Teeth and bearings are pressed by the load. Those that are preloaded by p feel a small one little; what
    friction they have without any is Coulomb friction.

    The load is `Motion.load`, the nominal torque through the gear; the measured torque would carry
    its noise, and the friction itself, into the column.

    Attributes:
        reversal: Velocity :math:`v_r` over which the sign changes [rad/s].
        preload: Torque that teeth and bearings carry without a load, :math:`p` [N m].
    """

    reversal: float = shape(0.003, "rad/s", 1e-4, 0.1)
    preload: float = 0.0

    needs_load: ClassVar[bool] = True
    greased: ClassVar[bool] = True
    plausible: ClassVar[float] = 0.3
    """Of a screw that holds itself it is one half, of toothed gears less; on a joint that bears next to none,
    nothing else says so."""

    @property
    def formula(self) -> Formula:
        return Formula(
            _profiles,
            (
                self.reversal,
                self.preload,
            ),
        )

    def parameters(self, robot: Robot) -> list[Parameter]:
        return self.on_each(robot, ("mu", "1", 0.0))

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, *self.profiles(motion))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        slope = smooth_sign_by_reversal(motion.velocity, self.reversal) * _pressed(motion.load, self.preload)
        return {"reversal": self.on_joints(robot, slope)}
