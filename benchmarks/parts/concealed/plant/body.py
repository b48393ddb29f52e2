"""Newton-Euler dynamics of a chain of bodies, for numba: shares nothing with what is under test.

Link frames turn about their own z; `rotation` and `translation` place joint j in link j - 1.
"""

import sys
from typing import NamedTuple

import numpy as np

try:
    from numba import njit
except ImportError:
    print(
        "numba is not installed: arms are simulated a thousand times slower. pip install '.[bench]'",
        file=sys.stderr,
    )

    def njit(**_options):  # type: ignore[no-untyped-def, no-redef]
        """Leave functions as they are."""
        return lambda function: function


__all__ = ["njit"]


class Body(NamedTuple):
    """Rigid bodies of an arm, each in its own link frame."""

    rotation: np.ndarray  # Of each joint at zero, to the frame before it, (n, 3, 3)
    translation: np.ndarray  # Of each joint in the frame before it, (n, 3) [m]
    mass: np.ndarray  # Shape (n,) [kg]
    com: np.ndarray  # Centre of mass, (n, 3) [m]
    inertia: np.ndarray  # About the centre of mass, (n, 3, 3) [kg m^2]
    gravity: np.ndarray  # In the base, (3,) [m/s^2]


def weld(body: Body, link: int, mass: float, com: np.ndarray, inertia: np.ndarray) -> Body:
    """The arm with another body (inertia about its own centre) fixed to a link."""
    total = body.mass[link] + mass
    centre = (body.mass[link] * body.com[link] + mass * com) / total
    parts = ((body.mass[link], body.com[link], body.inertia[link]), (mass, com, inertia))
    about = sum(
        i + m * (np.dot(c - centre, c - centre) * np.eye(3) - np.outer(c - centre, c - centre))
        for m, c, i in parts
    )
    new = [np.array(part) for part in (body.mass, body.com, body.inertia)]
    new[0][link], new[1][link], new[2][link] = total, centre, about
    return body._replace(mass=new[0], com=new[1], inertia=new[2])


@njit(cache=True)
def turn(rotation, position, turned):
    """Rotation of every link to the one before it at a position, into `turned` (n, 3, 3)."""
    for j in range(len(position)):
        c, s = np.cos(position[j]), np.sin(position[j])
        for k in range(3):
            turned[j, k, 0] = c * rotation[j, k, 0] + s * rotation[j, k, 1]
            turned[j, k, 1] = c * rotation[j, k, 1] - s * rotation[j, k, 0]
            turned[j, k, 2] = rotation[j, k, 2]


@njit(cache=True)
def flange(translation, turned, place, frame):
    """Position (3,) and rotation (3, 3) of the last link in the base."""
    place[:] = 0.0
    frame[:] = np.eye(3)
    for j in range(len(turned)):
        place[:] += frame @ translation[j]
        frame[:] = frame @ turned[j]


@njit(cache=True)
def cross(a, b, out):
    """Vector product."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@njit(cache=True)
def back(rotation, vector, out):
    """A vector of the frame before, in the link's own frame."""
    for k in range(3):
        out[k] = rotation[0, k] * vector[0] + rotation[1, k] * vector[1] + rotation[2, k] * vector[2]


@njit(cache=True)
def forth(rotation, vector, out):
    """A vector of the link's frame, in the frame before."""
    for k in range(3):
        out[k] = rotation[k, 0] * vector[0] + rotation[k, 1] * vector[1] + rotation[k, 2] * vector[2]


@njit(cache=True)
def inverse_dynamics(body, turned, velocity, acceleration, base, pull, torque):
    """Joint torques of a motion, into `torque` (n,) [N m].

    `base` is the acceleration of the base, gravity taken off, and `pull` the force on the flange from
    outside, in the last link's frame, both (3,).
    """
    n = len(velocity)
    force, moment = np.empty((n, 3)), np.empty((n, 3))
    spin, twist, linear = np.zeros(3), np.zeros(3), base.copy()
    a, b, c, d = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for j in range(n):
        p, r = body.translation[j], turned[j]
        cross(spin, p, a)
        cross(spin, a, b)
        cross(twist, p, c)
        for k in range(3):
            d[k] = linear[k] + b[k] + c[k]
        back(r, d, linear)
        back(r, spin, a)
        back(r, twist, b)
        b[0] += a[1] * velocity[j]
        b[1] -= a[0] * velocity[j]
        b[2] += acceleration[j]
        a[2] += velocity[j]
        spin[:], twist[:] = a, b
        centre = body.com[j]
        cross(spin, centre, a)
        cross(spin, a, b)
        cross(twist, centre, c)
        for k in range(3):
            force[j, k] = body.mass[j] * (linear[k] + b[k] + c[k])
        inertia = body.inertia[j]
        for k in range(3):
            a[k] = inertia[k, 0] * spin[0] + inertia[k, 1] * spin[1] + inertia[k, 2] * spin[2]
            c[k] = inertia[k, 0] * twist[0] + inertia[k, 1] * twist[1] + inertia[k, 2] * twist[2]
        cross(spin, a, b)
        cross(centre, force[j], d)
        for k in range(3):
            moment[j, k] = c[k] + b[k] + d[k]
    for k in range(3):
        force[n - 1, k] -= pull[k]
    torque[n - 1] = moment[n - 1, 2]
    for j in range(n - 1, 0, -1):
        forth(turned[j], force[j], a)
        forth(turned[j], moment[j], b)
        cross(body.translation[j], a, c)
        for k in range(3):
            force[j - 1, k] += a[k]
            moment[j - 1, k] += b[k] + c[k]
        torque[j - 1] = moment[j - 1, 2]


@njit(cache=True)
def mass_matrix(body, turned, matrix):
    """Joint-space inertia, into `matrix` (n, n) [kg m^2], by composite bodies from the flange to the base."""
    n = len(turned)
    mass, moment, inertia = 0.0, np.zeros(3), np.zeros((3, 3))  # of all links from j on, about j's origin
    force, torque, a, b = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for j in range(n - 1, -1, -1):
        mass += body.mass[j]
        for k in range(3):
            moment[k] += body.mass[j] * body.com[j, k]
        add_inertia(inertia, body.inertia[j], body.mass[j], body.com[j])
        force[0], force[1], force[2] = -moment[1], moment[0], 0.0  # of a unit acceleration about z
        torque[:] = inertia[:, 2]
        matrix[j, j] = torque[2]
        for i in range(j, 0, -1):
            forth(turned[i], force, a)
            forth(turned[i], torque, b)
            cross(body.translation[i], a, torque)
            for k in range(3):
                force[k], torque[k] = a[k], torque[k] + b[k]
            matrix[i - 1, j] = matrix[j, i - 1] = torque[2]
        if j > 0:
            carry(turned[j], body.translation[j], mass, moment, inertia)


@njit(cache=True)
def add_inertia(inertia, own, mass, com):
    """Add to an inertia about the origin that of a body, given about its own centre."""
    square = com[0] ** 2 + com[1] ** 2 + com[2] ** 2
    for k in range(3):
        for m in range(3):
            inertia[k, m] += own[k, m] - mass * com[k] * com[m]
        inertia[k, k] += mass * square


@njit(cache=True)
def carry(rotation, translation, mass, moment, inertia):
    """First moment (3,) and inertia (3, 3) about the origin of a frame, to those about the frame before."""
    half, turned = np.zeros((3, 3)), np.empty(3)
    for k in range(3):
        for m in range(3):
            for i in range(3):
                half[k, m] += rotation[k, i] * inertia[i, m]
    forth(rotation, moment, turned)
    # About p + x: |p + x|^2 1 - (p + x)(p + x)^T, summed over the masses at x.
    along = 0.0
    for k in range(3):
        along += translation[k] * (2.0 * turned[k] + mass * translation[k])
    for k in range(3):
        for m in range(3):
            whole = 0.0
            for i in range(3):
                whole += half[k, i] * rotation[m, i]
            inertia[k, m] = whole - translation[k] * turned[m] - turned[k] * translation[m]
            inertia[k, m] -= mass * translation[k] * translation[m]
        inertia[k, k] += along
    for k in range(3):
        moment[k] = turned[k] + mass * translation[k]


@njit(cache=True)
def solve(matrix, right, solution):
    """Solve with a symmetric positive matrix (n, n), which is overwritten by its triangular root."""
    n = len(right)
    for j in range(n):
        for k in range(j):
            for i in range(j, n):
                matrix[i, j] -= matrix[i, k] * matrix[j, k]
        root = np.sqrt(matrix[j, j])
        for i in range(j, n):
            matrix[i, j] /= root
    for j in range(n):
        solution[j] = right[j]
        for k in range(j):
            solution[j] -= matrix[j, k] * solution[k]
        solution[j] /= matrix[j, j]
    for j in range(n - 1, -1, -1):
        for k in range(j + 1, n):
            solution[j] -= matrix[k, j] * solution[k]
        solution[j] /= matrix[j, j]
