"""Inertia of links and rotors, with the gravity, centrifugal and Coriolis torque of the links."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin

from ..arm.body_units import arm_length
from ..arm.motion import Motion
from ..arm.rigid_regressor import INERTIAL, rigid_gradient, rigid_regressor
from ..arm.robot import Robot
from .effect import Effect, JointEffect, MotionGradient, Parameter, Prior
from .simulator_terms import JointTerms

UNITS = dict.fromkeys(INERTIAL[:6], "kg m^2") | dict.fromkeys(INERTIAL[6:9], "kg m") | {"M": "kg"}

USUAL_MASS, USUAL_RADIUS = 10.0, 0.1
"""Median mass of arms per cube of their length [kg/m^3], and radius of gyration of a link over it [-]."""
SHORTEST = 0.1
"""Length of an arm whose description has none, such as a turntable [m]."""


@dataclass(frozen=True)
class RigidBody(Effect):
    """The ten standard parameters of every link, about the origin of its frame (the paper's (3))."""

    transmitted: ClassVar[bool] = True
    smooth: ClassVar[bool] = True
    of_links: ClassVar[bool] = True

    def parameters(self, robot: Robot) -> list[Parameter]:
        return [
            Parameter(
                f"{name}{link + 1}",
                UNITS[name],
                minimum=0.0 if name in ("XX", "YY", "ZZ", "M") else -np.inf,
                # Khalil's choice: YY, MZ and M of a revolute link are regrouped into the preceding link.
                regroup=2 if name in ("YY", "MZ", "M") else 0,
            )
            for link in range(robot.dof)
            for name in INERTIAL
        ]

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return rigid_regressor(robot.kinematics, motion)

    def motion_gradient(
        self, robot: Robot, motion: Motion, weights: np.ndarray, known: np.ndarray
    ) -> MotionGradient:
        by = rigid_gradient(robot.kinematics, motion, weights)
        return MotionGradient(by[0], by[1], by[2], np.zeros_like(motion.position))

    def priors(self, robot: Robot) -> Mapping[str, Prior]:
        """Priors of all links, infinitely wide if the described bodies are missing or implausible."""
        tolerance = robot.inertial_tolerance if robot.body_units.informative else np.inf
        return {
            f"{name}{link}": prior
            for link, inertia in enumerate(tuple(robot.kinematics.inertias)[1:], 1)
            for name, prior in inertial_priors(inertia, tolerance).items()
        }

    def parameter_joints(self, robot: Robot) -> list[int | None]:
        return [link for link in range(robot.dof) for _ in INERTIAL]

    def inertias(self, robot: Robot) -> list[slice]:
        return [slice(10 * link, 10 * link + 10) for link in range(robot.dof)]

    def link_parameters(self, robot: Robot, values: np.ndarray, payload: str) -> np.ndarray:
        return values.reshape(robot.dof, len(INERTIAL))

    def bodies(self, robot: Robot, values: np.ndarray, payload: str) -> Mapping[int, pin.Inertia]:
        links = values.reshape(robot.dof, len(INERTIAL))
        if not all(is_body(parameters) for parameters in links):
            return {}
        return {link: body_inertia(parameters) for link, parameters in enumerate(links)}


@dataclass(frozen=True)
class RotorInertia(JointEffect):
    r"""Torque :math:`I_a \ddot q`, the paper's :math:`Ia_j`: rotor inertia times gear ratio squared."""

    smooth: ClassVar[bool] = True
    linear: ClassVar[bool] = True
    massless: ClassVar[bool] = False
    moved_by: ClassVar[tuple[str, ...]] = ("acceleration",)
    coefficients: ClassVar[tuple[tuple[Any, ...], ...]] = (("Ia", "kg m^2", 0.0),)

    def profiles(self, at: Any) -> tuple[Any, ...]:
        return (at.acceleration,)

    def portable(self, robot: Robot, values: np.ndarray) -> JointTerms:
        return self.terms(robot, armature=values)


def inertial_parameters(inertia: pin.Inertia) -> np.ndarray:
    """Ten parameters of a body in `INERTIAL` order, about the origin of its frame."""
    m, mx, my, mz, xx, xy, yy, xz, yz, zz = inertia.toDynamicParameters()
    return np.array([xx, xy, xz, yy, yz, zz, mx, my, mz, m])


def usual_body(robot: Robot) -> np.ndarray:
    """Ten parameters of a link of usual mass and size for an arm of this length, in `INERTIAL` order."""
    length = max(arm_length(robot.kinematics), SHORTEST)
    mass = USUAL_MASS * length**3 / robot.dof
    sphere = pin.Inertia(mass, np.zeros(3), mass * (USUAL_RADIUS * length) ** 2 * np.eye(3))
    return inertial_parameters(sphere)


def is_body(values: np.ndarray) -> bool:
    """Whether ten parameters have a positive mass or are all zero."""
    return bool(values[9] > 0.0 or not np.any(values))


def body_inertia(values: np.ndarray) -> pin.Inertia:
    """Inertia of a body from ten parameters in `INERTIAL` order; the inverse of `inertial_parameters`."""
    if not np.any(values):
        return pin.Inertia.Zero()
    xx, xy, xz, yy, yz, zz, mx, my, mz, m = values
    return pin.Inertia.FromDynamicParameters(np.array([m, mx, my, mz, xx, xy, yy, xz, yz, zz]))


def moved(values: np.ndarray, placement: pin.SE3) -> np.ndarray:
    """Ten parameters of a body in another frame, in which `placement` is that of its own frame, shape (10,).

    The second moments of the mass transform with the homogeneous matrix, so the parameters may also be
    combinations that no body can have.
    """
    xx, xy, xz, yy, yz, zz = values[:6]
    second = np.array(
        [[yy + zz - xx, -2 * xy, -2 * xz], [-2 * xy, xx + zz - yy, -2 * yz], [-2 * xz, -2 * yz, xx + yy - zz]]
    )
    first = values[6:9, None]
    moments = np.block([[second / 2, first], [first.T, values[9]]])
    moments = placement.homogeneous @ moments @ placement.homogeneous.T
    second = moments[:3, :3]
    inertia = np.trace(second) * np.eye(3) - second
    return np.array([*inertia[np.triu_indices(3)], *moments[:3, 3], moments[3, 3]])


def with_bodies(robot: Robot, bodies: np.ndarray) -> Robot:
    """Copy of a robot with other links, shape (n, 10), ten parameters each in `INERTIAL` order."""
    kinematics = robot.kinematics.copy()
    for link, values in enumerate(bodies):
        kinematics.inertias[link + 1] = body_inertia(values)
    return replace(robot, kinematics=kinematics)


def inertial_priors(inertia: pin.Inertia, tolerance: float) -> dict[str, Prior]:
    """Priors of a body's ten parameters.

    The tolerance is relative to the size of the body, so that a first moment that happens to be zero is not
    treated as certain. With mass m and rms distance r of the mass from the origin of the frame, the standard
    deviations are tolerance times m, m r and m r^2; that of the first moment applies to the length of the
    vector, with a third of its square along each axis.
    """
    values = inertial_parameters(inertia)
    mass = values[9]
    radius = np.sqrt(max(values[0] + values[3] + values[5], 0.0) / (2 * mass)) if mass > 0 else 0.0
    scale = np.array([mass * radius**2] * 6 + [mass * radius / np.sqrt(3.0)] * 3 + [mass])
    std = tolerance * scale if np.isfinite(tolerance) else np.full(10, np.inf)
    return {n: Prior(float(v), float(s)) for n, v, s in zip(INERTIAL, values, std, strict=True)}
