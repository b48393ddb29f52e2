r"""A rigid body in the flange frame, and 95 % intervals of its mass, center of mass and inertia.

The intervals are from ten parameters with their covariance. The center of mass is a ratio,
:math:`c = mc / m`. Its interval is Fieller's: all c for which :math:`mc - c\,m` is zero within its own
interval. Unlike linear propagation it holds for any mass, and is unbounded if the mass may be zero. The
inertia about the center of mass is propagated linearly, and its moments are at least zero. Physical
consistency is a bound on the truth and so never excludes it: an interval of the unconstrained estimate, cut
to possible values, still contains the truth as often as it says.
"""

from dataclasses import dataclass
from itertools import permutations, product
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..arm.rigid_regressor import INERTIAL
from ..effects.effect import Parameter
from ..effects.rigid_body import UNITS, body_inertia, inertial_parameters
from ..fit.base_parameters import BaseParameters
from ..fit.estimators.consistent import Held, nearest
from ..text_table import NORMAL_95

MASS = INERTIAL.index("M")
MOMENTS = slice(INERTIAL.index("MX"), INERTIAL.index("MZ") + 1)
ELEMENTS = np.triu_indices(3)
"""Places of the elements of an inertia in `INERTIAL` order: xx, xy, xz, yy, yz, zz."""


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
        body = body_inertia(parameters)
        return cls(float(body.mass), body.lever, body.inertia)

    @property
    def parameters(self) -> np.ndarray:
        """Ten parameters in `INERTIAL` order, about the origin of the flange, shape (10,)."""
        return inertial_parameters(pin.Inertia(self.mass, self.center, self.inertia))

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


STEP = 1e-6
"""Relative step of the central differences of the inertia."""
WIDE = 1e4
"""Standard deviation of the prior of the consistent parameters over that of the data: no effect."""


class Interval(NamedTuple):
    """A value with its 95 % interval; ends are infinite if the runs do not bound it."""

    value: float  # physically consistent value
    low: float  # lower end
    high: float  # upper end
    unit: str  # SI unit

    @property
    def half(self) -> float:
        """Half of the interval's width."""
        return 0.5 * (self.high - self.low)

    def holds(self, truth: float) -> bool:
        """Whether a value is in the interval."""
        return self.low <= truth <= self.high


class Intervals(NamedTuple):
    """Intervals of a body."""

    mass: Interval  # mass
    center: tuple[Interval, ...]  # x, y, z of the center of mass in the flange frame
    inertia: tuple[Interval, ...]  # xx, xy, xz, yy, yz, zz about the center of mass along the flange axes


def consistent_body(estimate: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Ten parameters with a positive definite pseudo-inertia, nearest in the metric of the covariance.

    Raises:
        FitError: The solver found none.
    """
    std = np.sqrt(np.diag(covariance))
    parameters = tuple(Parameter(name, UNITS[name]) for name in INERTIAL)
    base = BaseParameters(parameters, np.arange(10), np.eye(10), (1.0, 0.0))
    return nearest(Held(base, estimate, WIDE * std, (slice(0, 10),)), estimate, covariance)


def intervals(estimate: np.ndarray, covariance: np.ndarray, body: Body) -> Intervals:
    """Intervals from unconstrained parameters (10,), their covariance (10, 10), and the consistent body."""
    std = np.sqrt(np.diag(covariance))
    half = NORMAL_95 * std[MASS]
    mass = _cut(body.mass, estimate[MASS] - half, estimate[MASS] + half, 0.0, "kg")
    centers = tuple(
        Interval(float(value), *_with(_fieller(estimate, covariance, k), value), "m")
        for k, value in enumerate(body.center)
    )
    return Intervals(mass, centers, _inertia(estimate, covariance, body))


def _fieller(estimate: np.ndarray, covariance: np.ndarray, axis: int) -> tuple[float, float]:
    """Fieller's interval of one coordinate of the center [m]."""
    place = MOMENTS.start + axis
    moment, mass = estimate[place], estimate[MASS]
    square = NORMAL_95**2
    a = mass**2 - square * covariance[MASS, MASS]
    b = moment * mass - square * covariance[place, MASS]
    c = moment**2 - square * covariance[place, place]
    inside = b**2 - a * c
    if a <= 0.0 or inside < 0.0:  # the mass may be zero
        return -np.inf, np.inf
    return float((b - np.sqrt(inside)) / a), float((b + np.sqrt(inside)) / a)


def _inertia(estimate: np.ndarray, covariance: np.ndarray, body: Body) -> tuple[Interval, ...]:
    """Intervals of xx, xy, xz, yy, yz, zz about the center of mass."""
    unknown = estimate[MASS] <= NORMAL_95 * np.sqrt(covariance[MASS, MASS])
    slope = np.zeros((6, 10))
    for k in range(10):
        step = np.zeros(10)
        step[k] = STEP * max(abs(estimate[k]), np.sqrt(covariance[k, k]))
        difference = body_inertia(estimate + step).inertia - body_inertia(estimate - step).inertia
        slope[:, k] = difference[ELEMENTS] / (2.0 * step[k])
    middle, values = body_inertia(estimate).inertia[ELEMENTS], body.inertia[ELEMENTS]
    std = np.sqrt(np.einsum("ij,jk,ik->i", slope, covariance, slope))
    half = np.full(6, np.inf) if unknown else NORMAL_95 * std
    least = [0.0 if name in ("XX", "YY", "ZZ") else -np.inf for name in INERTIAL[:6]]
    return tuple(
        _cut(float(value), m - h, m + h, bound, "kg m^2")
        for value, m, h, bound in zip(values, middle, half, least, strict=True)
    )


def _cut(value: float, low: float, high: float, least: float, unit: str) -> Interval:
    """Interval cut to possible values; it contains the consistent value."""
    return Interval(value, *_with((max(low, least), max(high, least)), value), unit)


def _with(ends: tuple[float, float], value: float) -> tuple[float, float]:
    return min(float(ends[0]), float(value)), max(float(ends[1]), float(value))
