r"""Physically consistent standard parameters: each link has a physically possible mass distribution.

The ten parameters of a body belong to a mass distribution if and only if its pseudo-inertia

.. math:: J = \begin{bmatrix} \tfrac12 \mathrm{tr}(I) E - I & mc \\ mc^T & m \end{bmatrix}

is positive definite (Wensing, Kim, Slotine 2018). The consistent parameters nearest to the data solve a conic
program: a quadratic cost, one 4 x 4 linear matrix inequality per body, and minima such as non-negative
friction. Parameters that the data do not determine stay near their nominal values.
"""

from typing import NamedTuple

import clarabel
import numpy as np
from scipy import sparse

from ...errors import FitError
from ...positive_definite import spectrum
from ..base_parameters import BaseParameters
from ..equations import Equations
from .compressed import Compressed, Estimate
from .least_squares import finite_tolerance, given_nominal, weighted

MARGIN = 1e-6
"""Smallest eigenvalue of a pseudo-inertia, relative to the largest of the ten parameters; simulators accept
this."""
RESOLVED = 1e-6
"""Accuracy of the solver at a minimum, in standard deviations: a value nearer to its minimum is set to it."""
FINEST = 1e-6
"""Smallest standard deviation relative to the value: noise-free data would overflow the solver."""
LEAST = 1e-12
"""Smallest standard deviation relative to that of the prior, which also limits values of zero."""


def consistent(equations: Equations) -> Estimate:
    """Weighted least squares under physical consistency, with a prior at the nominal values.

    Raises:
        FitError: The solver found no consistent parameters.
    """
    start = weighted(equations)
    held = Held(equations.base, equations.nominal, finite_tolerance(equations), equations.bodies)
    # The covariance at known gains: the nearest parameters should reproduce the measured currents.
    standard = nearest(held, start.values, given_nominal(start))
    values = equations.base.regrouping @ standard
    noise = Compressed.of(equations).residual_std(values, equations.gain)
    # The unconstrained covariance is an upper bound where a constraint is active. If a constraint moves
    # values by several standard deviations, data and constraint contradict each other, and either may be
    # wrong by that much.
    moved = values - start.values
    covariance = start.covariance + np.pad(np.outer(moved, moved), (0, len(equations.gain)))
    return Estimate("consistent", values, equations.gain, covariance, noise, standard, nominal_gains=True)


class Held(NamedTuple):
    """Prior of the standard parameters."""

    base: BaseParameters  # base parameters, the combinations that the data determine
    nominal: np.ndarray  # nominal values, shape (p,)
    tolerance: np.ndarray  # standard deviations of the nominal values, finite and above zero, shape (p,)
    bodies: tuple[slice, ...]  # standard parameters of each rigid body, ten per body


def nearest(held: Held, values: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Consistent standard parameters (p,) nearest to base parameters (b,) in the metric of their covariance.

    Raises:
        FitError: The solver found no consistent parameters.
    """
    tolerance = held.tolerance
    standard, stacked = unconstrained(held, values, covariance)
    matrix, offset, cones = _constraints(held, standard)
    if _inside(offset, cones):
        return standard
    # Step back to the constraints. The solver needs unknowns of similar size: each is in units of its
    # standard deviation with all others fixed.
    unit = tolerance / np.linalg.norm(stacked, axis=0)
    stacked = stacked * (unit / tolerance)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    solution = clarabel.DefaultSolver(
        sparse.csc_matrix(np.triu(stacked.T @ stacked)), np.zeros(len(unit)),
        sparse.csc_matrix(matrix * unit), offset, cones, settings,
    ).solve()  # fmt: skip
    if str(solution.status) not in ("Solved", "AlmostSolved"):
        raise FitError(
            f"no physically consistent parameters found ({solution.status}); check the signs of the drive "
            "gains and the direction of gravity, which consistency cannot correct"
        )
    consistent = standard + unit * np.array(solution.x)
    minimum = np.array([parameter.minimum for parameter in held.base.parameters])
    minimum[np.concatenate([np.r_[body] for body in held.bodies] or [np.zeros(0, int)])] = -np.inf
    return np.where(np.abs(consistent - minimum) < RESOLVED * unit, minimum, consistent)


def unconstrained(held: Held, values: np.ndarray, covariance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Standard parameters (p,) without consistency constraints, and the rows (b + p, p) of data and prior.

    Unknowns are deviations from the prior in units of its tolerance, so that the prior is their sum of
    squares.
    """
    tolerance, regrouping = held.tolerance, held.base.regrouping
    whiten = whitening(held, values, covariance)
    right = whiten @ (values - regrouping @ held.nominal)
    stacked = np.concatenate([whiten @ regrouping * tolerance, np.eye(len(tolerance))])
    free = np.linalg.lstsq(stacked, np.concatenate([right, np.zeros(len(tolerance))]), rcond=None)[0]
    return held.nominal + tolerance * free, stacked


def whitening(held: Held, values: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Rows (b, b) that transform base parameters (b,) with covariance (b, b) to independent unit variance.

    Standard deviations have a lower limit; see `FINEST`. If the data hardly distinguish some unknowns,
    rounding can raise their correlation to one or above.
    """
    before = np.linalg.norm(held.base.regrouping * held.tolerance, axis=1)
    size = np.maximum(np.sqrt(np.diag(covariance)), FINEST * np.abs(values) + LEAST * before)
    scaled = covariance / np.outer(size, size)
    scaled[np.diag_indices(len(size))] = 1.0
    spread, axes = spectrum(scaled)
    return (axes / np.sqrt(spread)).T / size


def _constraints(held: Held, standard: np.ndarray) -> tuple[np.ndarray, np.ndarray, list]:
    """Constraints A x + s = b with s in cones, for a step x (p,) from the standard parameters (p,).

    The cones are the pseudo-inertias, then the minima of parameters that do not belong to a body.
    """
    blocks, offsets, cones = [np.zeros((0, len(standard)))], [np.zeros(0)], []
    outside = np.array([np.isfinite(parameter.minimum) for parameter in held.base.parameters])
    # Linear map (10, 10) from ten parameters to the triangle of their pseudo-inertia
    vectors = np.column_stack([triangle(pseudo_inertia(unit)) for unit in np.eye(10)])
    for body in held.bodies:
        outside[body] = False
        matrix = np.zeros((10, len(standard)))
        matrix[:, body] = -vectors
        scale = max(np.max(np.abs(standard[body])), 1e-12)  # avoids division by zero for a body without mass
        blocks.append(matrix / scale)
        offsets.append(vectors @ standard[body] / scale - MARGIN * triangle(np.eye(4)))
        cones.append(clarabel.PSDTriangleConeT(4))
    bounded = np.flatnonzero(outside)
    if len(bounded):
        minimum = np.array([held.base.parameters[k].minimum for k in bounded])
        scale = np.maximum(np.abs(standard[bounded]), 1e-12)
        blocks.append(-np.eye(len(standard))[bounded] / scale[:, None])
        offsets.append((standard[bounded] - minimum) / scale)
        cones.append(clarabel.NonnegativeConeT(len(bounded)))
    return np.concatenate(blocks), np.concatenate(offsets), cones


def _inside(offset: np.ndarray, cones: list) -> bool:
    """Whether all constraints already hold: pseudo-inertias are positive definite, minima are met."""
    start = 0
    for cone in cones:
        body = isinstance(cone, clarabel.PSDTriangleConeT)
        count = 10 if body else len(offset) - start
        part = offset[start : start + count]
        if np.min(np.linalg.eigvalsh(square(part)) if body else part) < 0:
            return False
        start += count
    return True


def square(packed: np.ndarray) -> np.ndarray:
    """Symmetric matrix (4, 4) from its packed triangle; the inverse of `triangle`."""
    rows, columns = np.tril_indices(4)[::-1]
    matrix = np.zeros((4, 4))
    matrix[rows, columns] = packed / np.where(rows == columns, 1.0, np.sqrt(2.0))
    return np.triu(matrix) + np.triu(matrix, 1).T


def triangle(matrix: np.ndarray) -> np.ndarray:
    """Upper triangle by columns with off-diagonals times root two, the packed format of the solver."""
    rows, columns = np.tril_indices(4)[::-1]
    return matrix[rows, columns] * np.where(rows == columns, 1.0, np.sqrt(2.0))


def pseudo_inertia(parameters: np.ndarray) -> np.ndarray:
    """Pseudo-inertia (4, 4) of ten parameters in `INERTIAL` order.

    Unlike an inertia about the center of mass, it is linear in the parameters, so that it transforms between
    frames even for physically impossible values.
    """
    xx, xy, xz, yy, yz, zz, mx, my, mz, m = parameters
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    pseudo = np.empty((4, 4))
    pseudo[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    pseudo[:3, 3] = pseudo[3, :3] = mx, my, mz
    pseudo[3, 3] = m
    return pseudo


def possible_body(parameters: np.ndarray) -> np.ndarray:
    """Ten parameters (10,) of the nearest body with positive mass and density everywhere."""
    pseudo = pseudo_inertia(parameters)
    if pseudo[3, 3] <= 0.0:
        return parameters
    radius = np.sqrt(max(np.trace(pseudo[:3, :3]), 0.0) / pseudo[3, 3]) or 1.0
    size = np.array([radius, radius, radius, 1.0])
    scale = np.outer(size, size)
    sizes, directions = np.linalg.eigh(pseudo / scale)
    if sizes[0] >= 0.0:
        return parameters
    sizes = np.maximum(sizes, RESOLVED * sizes[-1])
    return of_pseudo_inertia(scale * ((directions * sizes) @ directions.T))


def of_pseudo_inertia(pseudo: np.ndarray) -> np.ndarray:
    """Ten parameters (10,) from a pseudo-inertia (4, 4); the inverse of `pseudo_inertia`."""
    inertia = np.trace(pseudo[:3, :3]) * np.eye(3) - pseudo[:3, :3]
    rows, columns = np.triu_indices(3)
    return np.concatenate([inertia[rows, columns], pseudo[:3, 3], pseudo[3:, 3]])
