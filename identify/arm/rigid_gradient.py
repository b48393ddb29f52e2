r"""Gradient of a weighted sum of a rigid regressor's entries by the motion, for many samples at once.

For weights :math:`g` the sum :math:`\sum g_{tjc} Y_{tjc}(q, \dot q, \ddot q)` is differentiated backward
through the Newton-Euler recursion of `rigid_regressor`: each link hands to its parent what the sum gains
per unit of the parent's motion. One such pass costs about three regressors, whatever the number of
parameters or of singular values the weights were made of.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
import pinocchio as pin

from .motion import Motion
from .newton_euler import Joint, Link, base_link, cross, dot, fixed_joint, joints_of, links, step


@dataclass(frozen=True)
class Pull:
    """Gain of the sum per unit of a link's motion, fields as in `Link`.

    Attributes:
        omega: Shape (3, t).
        alpha: Shape (3, t).
        lift: Shape (3, t).
        linear: Shape (3, m, t).
        angular: Shape (3, m, t).
    """

    omega: np.ndarray
    alpha: np.ndarray
    lift: np.ndarray
    linear: np.ndarray
    angular: np.ndarray

    def __add__(self, other: "Pull") -> "Pull":
        pairs = ((getattr(self, f.name), getattr(other, f.name)) for f in fields(self))
        return Pull(*(one + two for one, two in pairs))


def rigid_gradient(kinematics: pin.Model, motion: Motion, weights: np.ndarray) -> np.ndarray:
    """Derivatives of sum(weights * rigid regressor) by position, velocity and acceleration, shape (3, t, n).

    Args:
        kinematics: Pinocchio model with n joints.
        motion: Of the joints.
        weights: Shape (t, n, 10 n).
    """
    chain = links(kinematics, motion)
    pulls = [_read(link, weights[:, :, 10 * index : 10 * index + 10]) for index, link in enumerate(chain)]
    return _inward(kinematics, chain, pulls, motion)


def body_gradient(kinematics: pin.Model, motion: Motion, flange: pin.SE3, weights: np.ndarray) -> np.ndarray:
    """The same for the regressor of a body fixed to the last link; weights (t, n, 10)."""
    chain = links(kinematics, motion)
    fixed, still = fixed_joint(flange), np.zeros(len(motion))
    body = step(len(chain), fixed, chain[-1], still, still, still)
    pull = _read(replace(body, moving=chain[-1].moving), weights)
    pulls = [_nothing(link) for link in chain]
    pulls[-1] = _step_back(fixed, chain[-1], body, pull, still, still)[0]
    return _inward(kinematics, chain, pulls, motion)


def _inward(kinematics: pin.Model, chain: list[Link], pulls: list[Pull], motion: Motion) -> np.ndarray:
    """From the tip to the base, each link's pull added to its parent's."""
    by = np.zeros((3, *motion.position.shape))
    base = base_link(kinematics, len(motion))
    joints = joints_of(kinematics)
    for index in range(len(chain) - 1, -1, -1):
        joint = joints[index]
        parent = base if joint.parent < 0 else chain[joint.parent]
        turn, rate = motion.position[:, index], motion.velocity[:, index]
        pull, by[:, :, index] = _step_back(joint, parent, chain[index], pulls[index], turn, rate)
        if joint.parent >= 0:
            pulls[joint.parent] = pulls[joint.parent] + pull
    return by


def _nothing(link: Link) -> Pull:
    return Pull(*(np.zeros_like(v) for v in (link.omega, link.alpha, link.lift, link.linear, link.angular)))


def _read(link: Link, weights: np.ndarray) -> Pull:
    """Pull of a link's own columns; weights (t, n, 10). The adjoint of writing them."""
    pull = np.zeros((10, link.linear.shape[1], len(weights)))
    for place, moving in enumerate(link.moving):
        pull[:, place] = weights[:, moving].T
    omega, alpha, lift = (vector[:, None] for vector in (link.omega, link.alpha, link.lift))
    z, linear = link.angular, link.linear
    y = cross(z, omega)
    by_z, by_y = _turn(pull, alpha), _turn(pull, omega)
    first, mass = pull[6:9], pull[9]
    across, along = dot(first, linear), dot(omega, linear)
    by_omega = _turn(pull, y) + cross(by_y, z) + first * along + linear * dot(first, omega)
    by_omega -= 2.0 * omega * across
    by_alpha = _turn(pull, z) + cross(first, linear)
    by_lift = cross(z, first) + mass * linear
    by_linear = cross(alpha, first) + omega * dot(first, omega) - first * dot(omega, omega) + mass * lift
    by_angular = by_z + cross(omega, by_y) + cross(first, lift)
    return Pull(by_omega.sum(1), by_alpha.sum(1), by_lift.sum(1), by_linear, by_angular)


def _turn(pull: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Symmetric matrix of the six inertia weights times a vector, all (3, m, t)."""
    xx, xy, xz, yy, yz, zz = pull[:6]
    x, y, z = vector
    return np.stack([xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z])


def _step_back(
    joint: Joint, parent: Link, link: Link, pull: Pull, turn: np.ndarray, rate: np.ndarray
) -> tuple[Pull, np.ndarray]:
    """Pull on the parent, and gain by the joint's own position, velocity, acceleration, shape (3, t)."""
    along = np.repeat(joint.axis[:, None], len(turn), axis=1)
    moving, before = along * rate, len(parent.moving)
    if joint.revolute:  # what the joint's own motion adds to the link's, from the vectors before it
        by_omega, alpha = pull.omega + cross(moving, pull.alpha), link.alpha - cross(link.omega, moving)
        by_rate = dot(along, pull.omega) + dot(pull.alpha, cross(link.omega, along))
        by_change = dot(along, pull.alpha)
        slide = 0.0 * turn
    else:
        by_omega, alpha = pull.omega + 2.0 * cross(moving, pull.lift), link.alpha
        by_rate, by_change = 2.0 * dot(pull.lift, cross(link.omega, along)), dot(along, pull.lift)
        turn, slide = 0.0 * turn, turn
    turned = np.stack([link.omega, alpha, link.lift], axis=1)
    pulls = np.stack([by_omega, pull.alpha, pull.lift], axis=1)
    linear, angular = pull.linear[:, :before], pull.angular[:, :before]
    twist = cross(turned, pulls).sum(1) + cross(link.linear, pull.linear).sum(1)
    twist += cross(link.angular, pull.angular).sum(1)
    outward = _outward(joint, turn, np.concatenate([pulls, linear, angular], axis=1))
    arm = joint.placement.translation[:, None] + joint.placement.rotation @ (along * slide)
    up, by_arm = _parent_pull(parent, arm, outward)
    slid = dot(joint.placement.rotation @ along, by_arm)
    return up, np.stack([-dot(along, twist) if joint.revolute else slid, by_rate, by_change])


def _outward(joint: Joint, turn: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (3, m, t) of the link's frame in the parent's."""
    along = np.repeat(joint.axis[:, None], len(turn), axis=1)[:, None]
    axial = along * dot(along, vectors)
    turned = axial + (vectors - axial) * np.cos(turn) + cross(along, vectors) * np.sin(turn)
    return (joint.placement.rotation @ turned.reshape(3, -1)).reshape(vectors.shape)


def _parent_pull(parent: Link, arm: np.ndarray, pulls: np.ndarray) -> tuple[Pull, np.ndarray]:
    """Pull on a parent from that on the vectors carried over `arm`, shape (3, t), and gain by the arm.

    Carried are omega, alpha, lift + alpha x arm + omega x (omega x arm), linear + angular x arm, angular.
    """
    by_omega, by_alpha, by_lift = pulls[:, 0], pulls[:, 1], pulls[:, 2]
    linear, angular = np.split(pulls[:, 3:], 2, axis=1)
    spin, lever = cross(by_lift, parent.omega), arm[:, None]
    by_omega = by_omega + cross(cross(parent.omega, arm), by_lift) + cross(arm, spin)
    by_arm = cross(by_lift, parent.alpha) + cross(spin, parent.omega) + cross(linear, parent.angular).sum(1)
    pull = Pull(by_omega, by_alpha + cross(arm, by_lift), by_lift, linear, angular + cross(lever, linear))
    return pull, by_arm
