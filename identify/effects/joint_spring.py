"""A spring across a joint: cables, hoses, or a torsion spring."""

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
class JointSpring(JointEffect):
    r"""Torque :math:`k (q - q_0)`, written linearly as :math:`K_s q + T_s` with :math:`T_s = -k q_0`.

    Cables and hoses stiffen as they stretch: the torque is then :math:`k (q - q_0) + k_3 (q - q_0)^3`, a
    polynomial :math:`T_s + K_s q + K_q q^2 + K_c q^3`. With a `CurrentOffset` on the same joint, :math:`T_s`
    and the offset have the same column.

    Attributes:
        stiffening: Whether the spring stiffens as it stretches.
    """

    stiffening: bool = False

    transmitted: ClassVar[bool] = True
    smooth: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ("position",)

    def parameters(self, robot: Robot) -> list[Parameter]:
        if not self.stiffening:
            return self.on_each(robot, ("Ks", "N m/rad", 0.0), ("Ts", "N m"))
        # A cable that is loose in the middle of its range may have negative stiffness there.
        more = ("Kq", "N m/rad^2"), ("Kc", "N m/rad^3", 0.0)
        return self.on_each(robot, ("Ks", "N m/rad"), ("Ts", "N m"), *more)

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        position = motion.position
        powers = [position, np.ones_like(position)]
        return self.on_joints(robot, *powers, *([position**2, position**3] if self.stiffening else []))

    def joint_torque(self, robot: Robot, values: np.ndarray, state: JointState) -> Sequence[Scalar]:
        def powers(joint: int) -> Sequence[Scalar]:
            q = state.position[joint]
            return (q, 1.0, q * q, q * q * q)[: 4 if self.stiffening else 2]

        return self.on_scalars(robot, values, powers)

    def portable(self, robot: Robot, values: np.ndarray) -> JointTerms | None:
        return None if self.stiffening else self.terms(robot, stiffness=values[::2], constant=values[1::2])
