r"""A motor that also turns when another joint moves, as in the wrist of most arms.

The paper's (22), with motor velocities divided by their gear ratios, is :math:`u = C \dot q` with a unit
diagonal; here :math:`u_j = \dot q_j + c\, \dot q_o`. Motors and their gears resist *their* motion with
torques :math:`f(u)`. By virtual work :math:`\dot q^T \tau = u^T f`, so the joint torques are

.. math:: \tau = C^T f(C \dot q): \qquad \tau_j = f_j(u_j), \quad \tau_o = f_o(\dot q_o) + c f_j(u_j).

The torque of a joint that moves alone belongs to its rotor inertia and friction, so the columns of this
effect exclude it. The remaining part of :math:`f_j = I_a \dot u + F_v u + F_c \tanh(u / v_r)` is

============  ==================================  ======================================
unknown       row :math:`j`                       row :math:`o`
============  ==================================  ======================================
:math:`cI_a`  :math:`\ddot q_o`                   :math:`\ddot q_j`
:math:`cF_v`  :math:`\dot q_o`                    :math:`\dot q_j`
:math:`F_c`   :math:`s(u_j) - s(\dot q_j)`        :math:`c\,(s(u_j) - s(c\,\dot q_o))`
============  ==================================  ======================================

The first two rows are exact and do not depend on the ratio. The product of inertia and the product of viscous
friction are off-diagonal terms of :math:`C^T I_a C` and :math:`C^T F_v C`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from ..errors import RobotError
from .effect import Effect, Parameter, shape
from .joint_state import JointState, Scalar
from .smooth_sign import smooth_sign, smooth_sign_by_reversal, smooth_sign_by_velocity

Sign = Callable[[np.ndarray, float], np.ndarray]


@dataclass(frozen=True)
class KinematicCoupling(Effect):
    """Inertia and friction of the motor of `joint` that also act on the joint `other`.

    Attributes:
        joint: Name of the joint that the motor drives.
        other: Name of the other joint that also turns this motor.
        ratio: Turns of the motor, over its gear ratio, per turn of the other joint [-].
        reversal: Velocity over which the sign of dry friction changes [rad/s].
    """

    joint: str
    other: str
    ratio: float = shape(1.0, "1", -2.0, 2.0)
    reversal: float = shape(0.003, "rad/s", 1e-4, 0.1)

    def parameters(self, robot: Robot) -> list[Parameter]:
        j, o = self._pair(robot)
        pair = f"{j + 1}_{o + 1}"
        return [
            Parameter(f"Ia{pair}", robot.unit(j, "kg m^2")),
            Parameter(f"Fv{pair}", robot.unit(j, "N m s/rad")),
            Parameter(f"Fc{pair}", robot.unit(j, "N m"), 0.0),
        ]

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        j, o = self._pair(robot)
        regressor = np.zeros((*motion.position.shape, 3))
        regressor[:, j, 0], regressor[:, o, 0] = motion.acceleration[:, o], motion.acceleration[:, j]
        regressor[:, j, 1], regressor[:, o, 1] = motion.velocity[:, o], motion.velocity[:, j]
        regressor[:, :, 2] = self._dry(robot, motion, smooth_sign)
        return regressor

    def joint_torque(self, robot: Robot, values: np.ndarray, state: JointState) -> Sequence[Scalar]:
        (j, o), (inertia, viscous, dry) = self._pair(robot), map(float, values)
        acceleration, velocity, torque = state.acceleration, state.velocity, [0.0] * robot.dof
        alone = self.ratio * velocity[o]
        motor, joint, other = (
            smooth_sign(v, self.reversal) for v in (velocity[j] + alone, velocity[j], alone)
        )
        torque[j] = inertia * acceleration[o] + viscous * velocity[o] + dry * (motor - joint)
        torque[o] = inertia * acceleration[j] + viscous * velocity[j] + dry * self.ratio * (motor - other)
        return torque

    def parameter_joints(self, robot: Robot) -> list[int | None]:
        return [self._pair(robot)[0]] * 3

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        j, o = self._pair(robot)
        by_ratio = np.zeros((*motion.position.shape, 3))
        by_reversal = np.zeros_like(by_ratio)
        by_reversal[:, :, 2] = self._dry(robot, motion, smooth_sign_by_reversal)
        motor, alone = self._motor_velocity(robot, motion)
        turn = motion.velocity[:, o]
        slope = smooth_sign_by_velocity(motor, self.reversal)
        slope_alone = smooth_sign_by_velocity(alone, self.reversal)
        signs = smooth_sign(motor, self.reversal) - smooth_sign(alone, self.reversal)
        by_ratio[:, j, 2] = slope * turn
        by_ratio[:, o, 2] = signs + self.ratio * turn * (slope - slope_alone)
        return {"ratio": by_ratio, "reversal": by_reversal}

    def _pair(self, robot: Robot) -> tuple[int, int]:
        j, o = robot.index(self.joint), robot.index(self.other)
        if j == o:
            raise RobotError(f"{robot.name}: joint '{self.joint}' cannot be coupled to itself; name another")
        return j, o

    def _motor_velocity(self, robot: Robot, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
        """Velocity of the motor, and its part from the other joint, each (t,) [rad/s]."""
        j, o = self._pair(robot)
        alone = self.ratio * motion.velocity[:, o]
        return motion.velocity[:, j] + alone, alone

    def _dry(self, robot: Robot, motion: Motion, sign: Sign) -> np.ndarray:
        """Last row of the table for `sign` or a derivative of it, shape (t, n)."""
        j, o = self._pair(robot)
        motor, alone = self._motor_velocity(robot, motion)
        torque = np.zeros_like(motion.velocity)
        torque[:, j] = sign(motor, self.reversal) - sign(motion.velocity[:, j], self.reversal)
        torque[:, o] = self.ratio * (sign(motor, self.reversal) - sign(alone, self.reversal))
        return torque
