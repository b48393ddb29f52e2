"""Friction that changes as the grease warms up."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from ..errors import NotRecorded
from .effect import JointEffect, shape
from .smooth_sign import smooth_sign, smooth_sign_by_reversal


@dataclass(frozen=True)
class TemperatureDependentFriction(JointEffect):
    r"""Torque :math:`(F_{vt}\, \dot q + F_{ct} \tanh(\dot q / v_r)) (T - T_0)`.

    The parameters are the changes of viscous and Coulomb friction per kelvin: grease thins
    (:math:`F_{vt} < 0`), while the friction of seals and preloaded bearings may increase or decrease. The
    parameters of `ViscousFriction` and `CoulombFriction` in the same model are then those at the reference
    temperature.

    Attributes:
        reference: Temperature :math:`T_0` [degC].
        reversal: Velocity :math:`v_r` over which the sign changes [rad/s].
    """

    reference: float = 25.0
    reversal: float = shape(0.003, "rad/s", 1e-4, 0.1)

    guessed: ClassVar[bool] = True
    needs_temperature: ClassVar[bool] = True
    coefficients: ClassVar[tuple[tuple[Any, ...], ...]] = (
        ("Fvt", "N m s/rad/K"),
        ("Fct", "N m/K"),
    )

    def profiles(self, at: Any) -> tuple[Any, ...]:
        warmth = at.temperature - self.reference
        return at.velocity * warmth, smooth_sign(at.velocity, self.reversal) * warmth

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        self._require_temperature(robot, motion)
        return self.on_joints(robot, *self.profiles(motion))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        self._require_temperature(robot, motion)
        warmth = motion.temperature - self.reference
        slope = smooth_sign_by_reversal(motion.velocity, self.reversal) * warmth
        return {"reversal": self.on_joints(robot, np.zeros_like(slope), slope)}

    def _require_temperature(self, robot: Robot, motion: Motion) -> None:
        """Raise if the temperature of a joint on which the effect acts is unknown."""
        missing = [robot.joints[j] for j in self.columns(robot) if np.isnan(motion.temperature[:, j]).any()]
        if missing:
            raise NotRecorded(
                f"{robot.name}: temperature-dependent friction needs the temperature of every sample, but "
                f"temperatures were not recorded, or have gaps, on {', '.join(missing)}; record them, or "
                "name only joints that have them (joints=...)"
            )
