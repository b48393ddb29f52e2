"""A payload on the flange."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pinocchio as pin

from ..arm.motion import Motion
from ..arm.rigid_regressor import INERTIAL, body_gradient, body_regressor
from ..arm.robot import Robot
from ..errors import RobotError, UnknownKey
from .effect import Effect, MotionGradient, Parameter, Prior
from .rigid_body import UNITS, body_inertia, inertial_parameters, is_body, moved


@dataclass(frozen=True)
class Payload(Effect):
    """A body on the flange, in the flange frame, in the runs that carry it.

    Known parameters cause a known torque; the others are unknowns such as the paper's ML and MZL. In a run
    with another `Motion.payload`, both are zero.

    Attributes:
        name: Name of the payload, at the end of each parameter's name.
        known: Pairs of a name in `INERTIAL` and its value in SI units; see `known_parameters`.
    """

    name: str = "L"
    known: tuple[tuple[str, float], ...] = ()

    transmitted: ClassVar[bool] = True
    smooth: ClassVar[bool] = True

    def __post_init__(self) -> None:
        names = [name for name, _ in self.known]
        for name in names:
            if name not in INERTIAL:
                raise UnknownKey(name, f"payload {self.name}", INERTIAL)
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise RobotError(f"payload {self.name}: known twice: {', '.join(twice)}")

    @property
    def payload(self) -> str:
        return self.name

    def parameters(self, robot: Robot) -> list[Parameter]:
        return [
            Parameter(f"{name}{self.name}", UNITS[name], 0.0 if name in ("XX", "YY", "ZZ", "M") else -np.inf)
            for name in self._unknown
        ]

    def priors(self, robot: Robot) -> Mapping[str, Prior]:
        """Inertia of a point, if mass and center alone are known: with none, no body would be simulated."""
        known = dict(self.known)
        if set(known) != set(INERTIAL[6:]):
            return {}
        mass, center = known["M"], np.array([known[name] for name in INERTIAL[6:9]]) / known["M"]
        values = inertial_parameters(pin.Inertia(mass, center, np.zeros((3, 3))))
        by_name = dict(zip(INERTIAL, values, strict=True))
        return {f"{name}{self.name}": Prior(float(by_name[name])) for name in self._unknown}

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self._columns(robot, motion, self._unknown)

    def known_torque(self, robot: Robot, motion: Motion) -> np.ndarray:
        values = np.array([value for _, value in self.known])
        return self._columns(robot, motion, [name for name, _ in self.known]) @ values

    def motion_gradient(
        self, robot: Robot, motion: Motion, weights: np.ndarray, known: np.ndarray
    ) -> MotionGradient:
        if motion.payload != self.name:
            return MotionGradient.none(motion.position.shape)
        all_weights = np.zeros((*motion.position.shape, len(INERTIAL)))
        all_weights[:, :, [INERTIAL.index(name) for name in self._unknown]] = weights
        for name, value in self.known:
            all_weights[:, :, INERTIAL.index(name)] = value * known
        by = body_gradient(robot.kinematics, motion, robot.flange, all_weights)
        return MotionGradient(by[0], by[1], by[2], np.zeros_like(motion.position))

    def inertias(self, robot: Robot) -> list[slice]:
        return [] if self.known else [slice(0, 10)]

    def link_parameters(self, robot: Robot, values: np.ndarray, payload: str) -> np.ndarray:
        links = np.zeros((robot.dof, len(INERTIAL)))
        if payload == self.name:
            links[-1] = moved(self._body(values), robot.flange)
        return links

    def _body(self, values: np.ndarray) -> np.ndarray:
        """Ten parameters of the body for values of the unknown parameters, shape (10,)."""
        by_name = dict(zip(self._unknown, values, strict=True)) | dict(self.known)
        return np.array([by_name[name] for name in INERTIAL])

    def bodies(self, robot: Robot, values: np.ndarray, payload: str) -> Mapping[int, pin.Inertia]:
        body = self._body(values)
        if payload != self.name or not is_body(body):
            return {}
        return {robot.dof - 1: robot.flange.act(body_inertia(body))}

    @property
    def _unknown(self) -> list[str]:
        known = dict(self.known)
        return [name for name in INERTIAL if name not in known]

    def _columns(self, robot: Robot, motion: Motion, names: Sequence[str]) -> np.ndarray:
        """Torque per unit of the named parameters, shape (t, n, len(names)) [N m / unit]."""
        if motion.payload != self.name or not names:
            return np.zeros((*motion.position.shape, len(names)))
        columns = body_regressor(robot.kinematics, motion, robot.flange)
        return columns[:, :, [INERTIAL.index(name) for name in names]]


def known_parameters(
    mass: float, com: Sequence[float] | None = None, inertia: Sequence[float] | None = None
) -> tuple[tuple[str, float], ...]:
    """Known parameters of a body that was weighed or is drawn, for `Payload.known`.

    Args:
        mass: Mass from a scale [kg].
        com: Center of mass in the flange frame, shape (3,) [m].
        inertia: xx, xy, xz, yy, yz, zz about the center of mass, in the axes of the flange [kg m^2].

    Raises:
        RobotError: The mass is not positive, a value is not finite, the inertia is given without the center
            of mass, or no body can have it.
    """
    if not 0.0 < mass < np.inf:
        raise RobotError(f"payload: mass is {mass} kg; it must be above 0 and finite")
    for name, value in (("com", com), ("inertia", inertia)):
        if value is not None and not np.all(np.isfinite(value)):
            raise RobotError(f"payload: {name} is {', '.join(map(str, value))}; all values must be finite")
    if com is None:
        if inertia is not None:
            raise RobotError("payload: inertia is about the center of mass, which is missing; give com too")
        return (("M", float(mass)),)
    xx, xy, xz, yy, yz, zz = (0.0,) * 6 if inertia is None else (float(value) for value in inertia)
    about_com = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    try:
        values = inertial_parameters(pin.Inertia(float(mass), np.asarray(com, float), about_com))
    except (RuntimeError, ValueError) as error:
        raise RobotError(f"payload: no body can have the inertia {about_com.tolist()}: {error}") from error
    names = INERTIAL[6:] if inertia is None else INERTIAL
    return tuple((name, float(values[INERTIAL.index(name)])) for name in names)
