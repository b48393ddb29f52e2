r"""Bodies that simulators accept: ten parameters moved, where they must be, to those of a possible body.

About the centre of mass, :math:`\Sigma = \tfrac12 \mathrm{tr}(I) E - I` is the second moment of the mass, and
so positive definite; that is the triangle inequality of the principal moments of inertia.
"""

import numpy as np

from ..fit.estimators.consistent import of_pseudo_inertia, pseudo_inertia

NOTHING = 1e-6
"""Least mass over the largest parameter of the arm's bodies: a link that is hardly there."""
EXTENT = 1e-3
"""Root mean square distance of the mass from its centre, in each direction, at least [m]; what is identified
under physical consistency has as much."""
ENOUGH = 0.5
"""Share of the least mass and of the least moment that is left alone. What was moved to the least is computed
again with rounding, which differs between processors: cancellation about the centre of mass leaves about
machine precision times the largest moment, a billionth of the least moment of usual links. Half is far from
that, and a body with half the least is still one that simulators accept."""


def possible(values: np.ndarray, largest: float) -> np.ndarray:
    """Ten parameters of a body with mass and extent in all directions; unchanged if they are that already.

    Mass and its centre are kept, unless there is no mass; second moments that are too small are raised, the
    least change in their sum of squares.

    Args:
        values: In `INERTIAL` order, shape (10,).
        largest: Of all parameters of the arm's bodies.
    """
    pseudo, nothing = pseudo_inertia(values), NOTHING * largest
    if pseudo[3, 3] < ENOUGH * nothing:
        pseudo = np.diag([0.0, 0.0, 0.0, nothing])
    around = np.outer(pseudo[:3, 3], pseudo[:3, 3]) / pseudo[3, 3]
    moments, axes = np.linalg.eigh(pseudo[:3, :3] - around)
    least = EXTENT**2 * pseudo[3, 3]
    if values[9] >= ENOUGH * nothing and moments[0] >= ENOUGH * least:
        return values
    pseudo[:3, :3] = (axes * np.maximum(moments, least)) @ axes.T + around
    return of_pseudo_inertia(pseudo)
