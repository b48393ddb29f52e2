r"""A spring that carries part of the arm's weight (the paper's section V.B).

The spring runs from a point fixed at distance :math:`d_{21}` from the joint's axis to a point of the
moving link at distance :math:`d_{22}` from it. With :math:`\theta = \phi + q` it has the length (32)

.. math:: l = \sqrt{d_{21}^2 + d_{22}^2 + 2 d_{21} d_{22} \cos\theta}, \qquad F = K_r l + K_0 .

(24) is :math:`\tau_{sb} = F d_{22} \sin\psi`. With both coordinates of (28) = (27),
:math:`\sin q_{23} = (d_{21} + d_{22} \cos\theta) / l` and :math:`\cos q_{23} = -d_{22} \sin\theta / l`,
so that (25) gives :math:`\sin\psi = -d_{21} \sin\theta / l` without an arctangent, and

.. math:: \tau_{sb} = -F d_{21} d_{22} \sin\theta / l .

This is the torque *on the joint*. The motor supplies the difference, so the columns are minus the paper's
(35). (36) adds (35) with its printed sign, but with the values of Table III only the sign used here supports
the arm: at :math:`q_2 = 0`, arm forward, the motor torque for gravity is -3.4 kN m and :math:`\tau_{sb}` is
-7.7 kN m.

(33) as printed, a plain arctangent, divides by zero at :math:`\theta = 0, \pm\pi`, the upright arm. Outside
:math:`-\pi < \theta < 0`, it is on the wrong branch, which changes the sign of the torque.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import Effect, MotionGradient, Parameter, shape
from .joint_state import JointState, Scalar
from .simulator_terms import Spring

SHORTEST = 1e-9
"""Length below which the ends of the spring coincide and its direction is undefined [m]."""


@dataclass(frozen=True)
class SpringBalancer(Effect):
    """Torque of a spring between two links, linear in stiffness and preload.

    Attributes:
        joint: Name of the joint that the spring spans.
        d21: Distance of the fixed end from the joint's axis [m].
        d22: Distance of the moving end from the joint's axis [m].
        phi: Angle between the two at joint position zero, zero where the spring is longest [rad].
    """

    joint: str
    d21: float = shape(None, "m", 0.01, 5.0)
    d22: float = shape(None, "m", 0.01, 5.0)
    phi: float = shape(None, "rad", -np.pi, np.pi)

    transmitted: ClassVar[bool] = True
    smooth: ClassVar[bool] = True
    massless: ClassVar[bool] = True

    def parameters(self, robot: Robot) -> list[Parameter]:
        return [Parameter("Kr", "N/m", 0.0), Parameter("K0", "N")]

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        position = self._position(robot, motion)
        area = self.d21 * self.d22 * np.sin(self.phi + position)
        return self._on_joint(robot, motion, area, area / self.length(position))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        position = self._position(robot, motion)
        sine, cosine = np.sin(self.phi + position), np.cos(self.phi + position)
        area, length = self.d21 * self.d22, self.length(position)
        # Derivatives of area * sine (the first column) and of the length with respect to each shape
        changes = {
            "d21": (self.d22 * sine, (self.d21 + self.d22 * cosine) / length),
            "d22": (self.d21 * sine, (self.d22 + self.d21 * cosine) / length),
            "phi": (area * cosine, -area * sine / length),
        }
        return {
            name: self._on_joint(robot, motion, first, first / length - area * sine * longer / length**2)
            for name, (first, longer) in changes.items()
        }

    def motion_gradient(
        self, robot: Robot, motion: Motion, weights: np.ndarray, known: np.ndarray
    ) -> MotionGradient:
        gradient = MotionGradient.none(motion.position.shape)
        turned = self.shape_derivatives(robot, motion)["phi"]  # position and phi have the same effect
        gradient.position[:, robot.index(self.joint)] = np.sum(weights * turned, axis=(1, 2))
        return gradient

    def joint_torque(self, robot: Robot, values: np.ndarray, state: JointState) -> Sequence[Scalar]:
        joint, torque = robot.index(self.joint), [0.0] * robot.dof
        position, (stiffness, preload) = state.position[joint], map(float, values)
        area = self.d21 * self.d22 * np.sin(self.phi + position)
        torque[joint] = stiffness * area + preload * (area / self.length(position))
        return torque

    def parameter_joints(self, robot: Robot) -> list[int | None]:
        return [robot.index(self.joint)] * 2

    def portable(self, robot: Robot, values: np.ndarray) -> Spring:
        return Spring(self.joint, self.d21, self.d22, self.phi, float(values[0]), float(values[1]))

    def length(self, position: Any) -> Any:
        """Length of the spring [m] at positions of the joint [rad]."""
        theta = self.phi + position
        # hypot, since the radicand of (32) loses digits or becomes negative where the ends nearly meet.
        length = np.hypot(self.d21 + self.d22 * np.cos(theta), self.d22 * np.sin(theta))
        return np.maximum(length, SHORTEST)

    def _position(self, robot: Robot, motion: Motion) -> np.ndarray:
        return motion.position[:, robot.index(self.joint)]

    def _on_joint(self, robot: Robot, motion: Motion, *columns: np.ndarray) -> np.ndarray:
        regressor = np.zeros((*motion.position.shape, len(columns)))
        joint = robot.index(self.joint)
        for place, column in enumerate(columns):
            regressor[:, joint, place] = column
        return regressor
