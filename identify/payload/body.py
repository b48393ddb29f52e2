"""A rigid body in the flange frame: mass, center of mass, and inertia about the center of mass."""

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from ..arm.rigid_regressor import INERTIAL

MASS = INERTIAL.index("M")
MOMENTS = slice(INERTIAL.index("MX"), INERTIAL.index("MZ") + 1)
ROWS, COLUMNS = np.triu_indices(3)
"""Elements of an inertia in `INERTIAL` order: xx, xy, xz, yy, yz, zz."""


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body."""

    mass: float  # mass [kg]
    center: np.ndarray  # center of mass in the flange frame, shape (3,) [m]
    # Inertia about the center of mass, along the flange axes, shape (3, 3) [kg m^2]. Off-diagonal elements
    # are minus the integral of x y, as in URDF, MJCF and Pinocchio.
    inertia: np.ndarray

    @classmethod
    def of(cls, parameters: np.ndarray) -> "Body":
        """The body of ten parameters in `INERTIAL` order, about the origin of the flange."""
        mass, center = float(parameters[MASS]), parameters[MOMENTS] / parameters[MASS]
        return cls(mass, center, symmetric(about_center(parameters)))

    @property
    def parameters(self) -> np.ndarray:
        """Ten parameters in `INERTIAL` order, about the origin of the flange, shape (10,)."""
        about_flange = self.inertia + self.mass * steiner(self.center)
        return np.concatenate([about_flange[ROWS, COLUMNS], self.mass * self.center, [self.mass]])

    @property
    def principal(self) -> tuple[np.ndarray, np.ndarray]:
        """Principal moments (3,) [kg m^2], and their axes as the columns of a rotation matrix (3, 3).

        Of the 24 right-handed sets of axes, the result is the one nearest to the flange axes: a body whose
        axes are those of the flange keeps them.
        """
        moments, axes = np.linalg.eigh(self.inertia)
        sets = [
            (list(order), axes[:, list(order)] * np.array(signs))
            for order in permutations(range(3))
            for signs in product((1.0, -1.0), repeat=3)
        ]
        right_handed = [(order, rotation) for order, rotation in sets if np.linalg.det(rotation) > 0.0]
        order, rotation = max(right_handed, key=lambda pair: float(np.trace(pair[1])))
        return moments[order], rotation


def about_center(parameters: np.ndarray) -> np.ndarray:
    """Inertia about the center of mass of ten parameters, six elements in `INERTIAL` order, shape (6,)."""
    shift = parameters[MASS] * steiner(parameters[MOMENTS] / parameters[MASS])
    return np.asarray(parameters[:6] - shift[ROWS, COLUMNS])


def symmetric(elements: np.ndarray) -> np.ndarray:
    """Symmetric matrix (3, 3) from xx, xy, xz, yy, yz, zz."""
    matrix = np.zeros((3, 3))
    matrix[ROWS, COLUMNS] = matrix[COLUMNS, ROWS] = elements
    return matrix


def steiner(center: np.ndarray) -> np.ndarray:
    """Inertia of a unit point mass at `center` about the origin, shape (3, 3) [m^2]."""
    return np.asarray(center @ center * np.eye(3) - np.outer(center, center))
