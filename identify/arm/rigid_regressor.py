r"""Regressor of a tree of rigid bodies, for many samples at once.

Newton-Euler: with angular velocity :math:`\omega`, angular acceleration :math:`\dot\omega` and
acceleration minus gravity :math:`a` of a link's frame origin, all in that frame, its wrench is

.. math::
    f = m a + \dot\omega \times mc + \omega \times (\omega \times mc), \qquad
    \mu = I \dot\omega + \omega \times I \omega + mc \times a.

The torque of joint j that it needs is :math:`l \cdot f + z \cdot \mu`, where :math:`(l, z)` is the
velocity of that frame when joint j alone moves at 1 rad/s. Vectors are kept as (3, t), those of the m
joints that move a link as (3, m, t), so that each operation runs over contiguous samples.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from .motion import Motion
from .newton_euler import Link, Pairs, cached_groups, cross, dot, fixed_joint, links, step

INERTIAL = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
"""The ten inertial parameters of a body about its frame's origin, in the paper's order (3)."""


def rigid_regressor(kinematics: pin.Model, motion: Motion) -> np.ndarray:
    """Joint torque per inertial parameter, shape (t, n, 10 n): `INERTIAL` of link 1, of link 2 and so on."""
    out = np.zeros((*motion.position.shape, kinematics.nv, 10))
    _write(links(kinematics, motion), out)
    return out.reshape(*motion.position.shape, -1)


def body_regressor(kinematics: pin.Model, motion: Motion, placement: pin.SE3) -> np.ndarray:
    """Joint torque per `INERTIAL` parameter of a body fixed to the last link, shape (t, n, 10).

    Args:
        kinematics: Pinocchio model with n joints.
        motion: Of the joints.
        placement: The body's frame in the last link's; the parameters are about its origin and axes.
    """
    last, still = links(kinematics, motion)[-1], np.zeros(len(motion))
    body = step(kinematics.nv, fixed_joint(placement), last, still, still, still)
    out = np.zeros((*motion.position.shape, 1, 10))
    _write([replace(body, moving=last.moving)], out)
    return out[:, :, 0]


def _write(chain: Sequence[Link], out: np.ndarray) -> None:
    """Torque of every joint per inertial parameter of some links, into out (t, n, links, 10)."""
    for first, some in cached_groups(chain):
        pairs = Pairs.of(some)
        out[:, pairs.joints, first + pairs.links] = _columns(pairs).T


def _columns(pairs: Pairs) -> np.ndarray:
    """The same of each pair of link and joint, shape (10, p, t)."""
    omega, alpha, lift, linear, z = pairs[2:]
    y = cross(z, omega)
    columns = np.empty((10, *z.shape[1:]))
    for column, (i, j) in enumerate(((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))):
        np.multiply(z[i], alpha[j], out=columns[column])
        columns[column] += y[i] * omega[j]
        if i != j:
            columns[column] += z[j] * alpha[i]
            columns[column] += y[j] * omega[i]
    along = dot(omega, linear)
    columns[6:9] = cross(linear, alpha) + omega * along - linear * dot(omega, omega) + cross(lift, z)
    columns[9] = dot(linear, lift)
    return columns
