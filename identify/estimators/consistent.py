r"""Physically consistent standard parameters: every link a body that can exist.

A body's ten parameters can belong to some distribution of mass if and only if its pseudo-inertia

.. math:: J = \begin{bmatrix} \tfrac12 \mathrm{tr}(I) E - I & mc \\ mc^T & m \end{bmatrix}

is positive definite (Wensing, Kim, Slotine 2018). Nearest to the data among those is a conic program:
quadratic in the parameters, one 4 x 4 linear matrix inequality a body, and minima such as non-negative
friction. What the data do not see is drawn to the believed values.
"""

import clarabel
import numpy as np
from scipy import sparse

from ..equations import Equations
from ..errors import FitError
from .bayesian import finite_tolerance
from .compressed import Compressed
from .estimate import Estimate
from .least_squares import weighted

MARGIN = 1e-6
"""Smallest eigenvalue of a pseudo-inertia over the body's believed size, so that simulators accept it."""


def consistent(equations: Equations) -> Estimate:
    """Weighted least squares under physical consistency, with a prior toward the believed values.

    Raises:
        FitError: The solver found no consistent parameters.
    """
    start = weighted(equations)
    standard = nearest(equations, start.values, start.covariance[: len(start.values), : len(start.values)])
    values = equations.base.regrouping @ standard
    noise = Compressed.of(equations).residual_std(values, equations.gain)
    # The unconstrained covariance: an upper bound where a constraint holds.
    return Estimate("consistent", values, equations.gain, start.covariance, noise, standard)


def nearest(equations: Equations, values: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Consistent standard parameters (p,) nearest to base parameters (b,) in their covariance (b, b)."""
    tolerance = finite_tolerance(equations)
    # Unknowns are deviations from the belief in units of its tolerance: all of a size, and the prior
    # is their sum of squares.
    size = np.sqrt(np.diag(covariance))
    whiten = np.linalg.inv(np.linalg.cholesky(covariance / np.outer(size, size))) / size
    rows = whiten @ equations.base.regrouping * tolerance
    right = whiten @ (values - equations.base.regrouping @ equations.believed)
    count = len(tolerance)
    quadratic = sparse.csc_matrix(np.triu(rows.T @ rows + np.eye(count)))
    matrix, offset, cones = _constraints(equations, tolerance)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    solution = clarabel.DefaultSolver(quadratic, -rows.T @ right, matrix, offset, cones, settings).solve()
    if str(solution.status) not in ("Solved", "AlmostSolved"):
        raise FitError(
            f"no physically consistent parameters found ({solution.status}); check the signs of the drive "
            "gains and the direction of gravity, which consistency cannot mend"
        )
    return equations.believed + tolerance * np.array(solution.x)


def _constraints(equations: Equations, tolerance: np.ndarray) -> tuple[sparse.csc_matrix, np.ndarray, list]:
    """A x + s = b with s in cones: pseudo-inertias, then minima of the parameters outside bodies."""
    blocks, offsets, cones = [], [], []
    inside: set[int] = set()
    for body in equations.bodies:
        inside |= set(range(body.start, body.stop))
        vectors = pseudo_inertia_vectors()
        matrix = np.zeros((10, len(tolerance)))
        matrix[:, body] = -vectors * tolerance[body]
        scale = max(np.max(np.abs(equations.believed[body])), np.finfo(float).tiny)
        floor = MARGIN * scale * triangle(np.eye(4))
        blocks.append(matrix / scale)
        offsets.append((vectors @ equations.believed[body] - floor) / scale)
        cones.append(clarabel.PSDTriangleConeT(4))
    bounded = [
        k for k, p in enumerate(equations.base.parameters) if np.isfinite(p.minimum) and k not in inside
    ]
    if bounded:
        matrix = np.zeros((len(bounded), len(tolerance)))
        matrix[np.arange(len(bounded)), bounded] = -1.0
        minimum = np.array([equations.base.parameters[k].minimum for k in bounded])
        blocks.append(matrix)
        offsets.append((equations.believed[bounded] - minimum) / tolerance[bounded])
        cones.append(clarabel.NonnegativeConeT(len(bounded)))
    return sparse.csc_matrix(np.concatenate(blocks)), np.concatenate(offsets), cones


def triangle(matrix: np.ndarray) -> np.ndarray:
    """Upper triangle by columns with off-diagonals times root two, as the solver takes it."""
    rows, columns = np.tril_indices(4)[::-1]
    return matrix[rows, columns] * np.where(rows == columns, 1.0, np.sqrt(2.0))


def pseudo_inertia(parameters: np.ndarray) -> np.ndarray:
    """Pseudo-inertia (4, 4) of ten parameters in `INERTIAL` order."""
    xx, xy, xz, yy, yz, zz, mx, my, mz, m = parameters
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    pseudo = np.empty((4, 4))
    pseudo[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    pseudo[:3, 3] = pseudo[3, :3] = mx, my, mz
    pseudo[3, 3] = m
    return pseudo


def pseudo_inertia_vectors() -> np.ndarray:
    """Linear map from ten parameters to the triangle of their pseudo-inertia, shape (10, 10)."""
    return np.column_stack([triangle(pseudo_inertia(unit)) for unit in np.eye(10)])
