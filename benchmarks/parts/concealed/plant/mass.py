"""Joint-space inertia of a chain of bodies, and solving with it."""

import numpy as np

from .body import cross, forth
from .jit import njit


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
