r"""Regressor of a tree of rigid bodies, for many samples at once.

Newton-Euler: with angular velocity :math:`\omega`, angular acceleration :math:`\dot\omega` and
acceleration minus gravity :math:`a` of a link's frame origin, all in that frame, its wrench is

.. math::
    f = m a + \dot\omega \times mc + \omega \times (\omega \times mc), \qquad
    \mu = I \dot\omega + \omega \times I \omega + mc \times a.

The torque of joint j that it needs is :math:`l \cdot f + z \cdot \mu`, where :math:`(l, z)` is the
velocity of that frame when joint j alone moves at 1 rad/s. Vectors are kept as (3, t), so that each
operation runs over contiguous samples; a Python loop over samples costs twice as much.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

INERTIAL = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
"""The ten inertial parameters of a body about its frame's origin, in the paper's order (3)."""


@dataclass(frozen=True)
class Joint:
    """One joint of the tree: parent link (-1 for the base), placement there, axis, and kind."""

    parent: int
    placement: pin.SE3
    axis: np.ndarray
    revolute: bool


def joints_of(kinematics: pin.Model) -> list[Joint]:
    """The tree of a Pinocchio model whose joints have one degree of freedom each."""
    joints = []
    for index in range(1, kinematics.njoints):
        joint = kinematics.joints[index]
        data = joint.createData()
        joint.calc(data, np.zeros(kinematics.nq), np.zeros(kinematics.nv))
        motion = np.asarray(data.S, float).reshape(6)
        revolute = bool(np.any(motion[3:]))
        axis = motion[3:] if revolute else motion[:3]
        joints.append(Joint(kinematics.parents[index] - 1, kinematics.jointPlacements[index], axis, revolute))
    return joints


def rigid_regressor(
    kinematics: pin.Model,
    position: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    out: np.ndarray,
) -> np.ndarray:
    """Write joint torque per inertial parameter into `out`, which must be zero above the diagonal.

    Args:
        kinematics: Pinocchio model with n joints.
        position: Shape (t, n) [rad] or [m].
        velocity: Shape (t, n) [rad/s].
        acceleration: Shape (t, n) [rad/s^2].
        out: Zeros of shape (t, n, 10 n); columns are `INERTIAL` of link 1, of link 2 and so on.
    """
    for index, state in enumerate(_links(kinematics, position, velocity, acceleration)):
        _write(state, out[:, :, 10 * index : 10 * index + 10])
    return out


def body_regressor(
    kinematics: pin.Model,
    position: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    placement: pin.SE3,
) -> np.ndarray:
    """Joint torque per `INERTIAL` parameter of a body fixed to the last link, shape (t, n, 10).

    Args:
        kinematics: Pinocchio model with n joints.
        position: Shape (t, n) [rad] or [m].
        velocity: Shape (t, n) [rad/s].
        acceleration: Shape (t, n) [rad/s^2].
        placement: The body's frame in the last link's; the parameters are about its origin and axes.
    """
    last = _links(kinematics, position, velocity, acceleration)[-1]
    out = np.zeros((*position.shape, 10))
    # A joint without an axis does not move: its frame is the body's.
    fixed, still = Joint(kinematics.nv - 1, placement, np.zeros(3), True), np.zeros(len(position))
    *state, moving = _step(kinematics.nv, fixed, last, still, still, still)
    del moving[kinematics.nv]
    _write((*state, moving), out)
    return out


def _links(
    kinematics: pin.Model, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
) -> list[tuple]:
    """Angular velocity, angular acceleration, lift and unit-joint velocities of every link's frame."""
    samples = len(position)
    still = np.zeros((3, samples))
    rising = np.repeat(-np.array(kinematics.gravity.linear)[:, None], samples, axis=1)
    base: tuple = (still, still, rising, {})
    links: list[tuple] = []
    for index, joint in enumerate(joints_of(kinematics)):
        parent = base if joint.parent < 0 else links[joint.parent]
        state = _step(index, joint, parent, position[:, index], velocity[:, index], acceleration[:, index])
        links.append(state)
    return links


def _write(state: tuple, out: np.ndarray) -> None:
    """Torque of every joint that moves a frame, into out (t, n, 10)."""
    body = Body(*state[:3])
    for moving, (linear, angular) in state[3].items():
        body.torque(linear, angular, out[:, moving])


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    out = np.empty((3, max(np.shape(a)[1], np.shape(b)[1])))
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    return out


def _step(index: int, joint: Joint, parent: tuple, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> tuple:
    """Velocity, acceleration and unit-joint velocities of the next link's frame, in that frame."""
    omega, alpha, lift, moving = parent
    axis = joint.axis[:, None]
    turn, slide = (q, 0.0 * q) if joint.revolute else (0.0 * q, q)
    offset = joint.placement.translation[:, None] + joint.placement.rotation @ (axis * slide)
    inward = _inward_rotation(joint, turn)
    lift = lift + _cross(alpha, offset) + _cross(omega, _cross(omega, offset))
    omega, alpha, lift = (inward(vector) for vector in (omega, alpha, lift))
    moving = {
        other: (inward(linear + _cross(angular, offset)), inward(angular))
        for other, (linear, angular) in moving.items()
    }
    along = np.repeat(axis, len(q), axis=1)
    if joint.revolute:
        alpha = alpha + _cross(omega, along * dq) + along * ddq
        omega = omega + along * dq
        moving[index] = (np.zeros_like(along), along)
    else:
        lift = lift + 2.0 * _cross(omega, along * dq) + along * ddq
        moving[index] = (along, np.zeros_like(along))
    return omega, alpha, lift, moving


def _inward_rotation(joint: Joint, turn: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Function that takes (3, t) vectors from the parent's frame into the link's (Rodrigues)."""
    axis, cosine, sine = joint.axis, np.cos(turn), np.sin(turn)
    across = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    to_placement = joint.placement.rotation.T
    along, cross = np.outer(axis, axis) @ to_placement, across @ to_placement
    level = to_placement - along

    def inward(vector: np.ndarray) -> np.ndarray:
        return along @ vector + (level @ vector) * cosine - (cross @ vector) * sine

    return inward


class Body:
    """Wrench of one link per inertial parameter; see the formulas at the top of this file."""

    def __init__(self, omega: np.ndarray, alpha: np.ndarray, lift: np.ndarray) -> None:
        self.omega, self.alpha, self.lift = omega, alpha, lift
        self.square = np.einsum("it,it->t", omega, omega)

    def torque(self, linear: np.ndarray, angular: np.ndarray, out: np.ndarray) -> None:
        """Torque of a joint that moves this frame with (linear, angular), into out (t, 10)."""
        omega, alpha, z = self.omega, self.alpha, angular
        y = _cross(z, omega)
        columns = np.empty((10, out.shape[0]))
        for column, (i, j) in enumerate(((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))):
            columns[column] = z[i] * alpha[j] + y[i] * omega[j]
            if i != j:
                columns[column] += z[j] * alpha[i] + y[j] * omega[i]
        along = np.einsum("it,it->t", omega, linear)
        columns[6:9] = _cross(linear, alpha) + omega * along - linear * self.square + _cross(self.lift, z)
        columns[9] = np.einsum("it,it->t", linear, self.lift)
        out[:] = columns.T
