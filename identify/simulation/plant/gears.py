"""Elastic gears with backlash, and joints that warm up by the losses of motors and gears."""

from dataclasses import dataclass
from math import exp

import numpy as np
import pinocchio as pin

from ...effects import RotorInertia
from ...errors import RobotError
from ...model import Model
from .steps import Elastic

POSES = 64
"""Number of random poses over which inertia and load are averaged."""
AMBIENT = 25.0
"""Temperature around the arm [degC]."""
TINY = 1e-9
"""Minimum inertia of a link [kg m^2]."""
LIGHT = 0.01
"""Inertia of a motor that has none in the model, relative to that of its link [-]: too small to be visible in
a torque, but enough for the motor to move separately."""


@dataclass(frozen=True, eq=False)
class Transmission:
    """A spring and a damper between each motor and its link, both on the joint side."""

    stiffness: np.ndarray  # stiffness, shape (n,) [N m/rad]; infinite for a rigid gear
    damping: np.ndarray  # damping coefficient, shape (n,) [N m s/rad]
    # Width of the play in which neither spring nor damper is in contact, shape (n,) [rad].
    backlash: np.ndarray

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping", "backlash"):
            value = np.asarray(getattr(self, name), float)
            if value.shape != np.shape(self.stiffness) or np.any(np.isnan(value)) or np.any(value < 0):
                raise RobotError(
                    f"transmission: {name} is {value}; expected one number per joint, none below 0"
                )
            object.__setattr__(self, name, value)
        if np.any(self.stiffness == 0.0):
            raise RobotError("transmission: a stiffness of 0 leaves a link without drive; use inf for rigid")
        if np.any((self.backlash > 0.0) & np.isinf(self.stiffness)):
            raise RobotError("transmission: a gear with backlash needs a finite stiffness")

    @classmethod
    def rigid(cls, joints: int) -> "Transmission":
        """Rigid gears."""
        return cls(np.full(joints, np.inf), np.zeros(joints), np.zeros(joints))

    @classmethod
    def of(cls, model: Model) -> "Transmission":
        """The gears of a model."""
        gears = cls.rigid(model.robot.dof)
        inertia = link_size(model)[0] if model.gears else ()
        for gear in model.gears:
            joint = model.robot.index(gear.joint)
            mask = np.arange(model.robot.dof) == joint
            spring = gear.spring(max(float(inertia[joint]), TINY))
            gears = gears.softened(
                np.where(mask, spring.stiffness, np.inf), mask * spring.damping, mask * spring.backlash
            )
        return gears

    def softened(self, stiffness: np.ndarray, damping: np.ndarray, backlash: np.ndarray) -> "Transmission":
        """Gears with other springs (n,) in series, and the larger damping and backlash of both."""
        with np.errstate(divide="ignore"):
            series = 1.0 / (1.0 / self.stiffness + 1.0 / np.asarray(stiffness))
        return Transmission(series, np.maximum(self.damping, damping), np.maximum(self.backlash, backlash))

    @property
    def elastic(self) -> np.ndarray:
        """Joints whose motor can move without the link, shape (m,)."""
        return np.flatnonzero(np.isfinite(self.stiffness))

    @property
    def links(self) -> np.ndarray:
        """Matrix from the plant's coordinates, all links and then the elastic joints' motors, to links."""
        return np.eye(len(self.stiffness), len(self.stiffness) + len(self.elastic))

    @property
    def motors(self) -> np.ndarray:
        """Matrix that maps the plant's coordinates to motor positions on the joint side, shape (n, n + m)."""
        n, matrix = len(self.stiffness), self.links
        matrix[self.elastic] = 0.0
        matrix[self.elastic, n + np.arange(len(self.elastic))] = 1.0
        return matrix

    def twist(self, torque: np.ndarray) -> np.ndarray:
        """Lead of the motors over their links when they hold a torque (n,) [N m], shape (n,) [rad]."""
        return torque / self.stiffness + 0.5 * self.backlash * np.sign(torque)

    @property
    def springs(self) -> Elastic:
        """Springs of the gears in the plant's coordinates."""
        joints = self.elastic
        stretch = (self.motors - self.links)[joints]
        return Elastic(
            stretch=stretch,
            transposed=stretch.T.copy(),
            stiffness=self.stiffness[joints],
            damping=self.damping[joints],
            play=0.5 * self.backlash[joints],
        )


def with_motors(model: Model, values: np.ndarray, elastic: np.ndarray) -> tuple[Model, np.ndarray]:
    """The model and its values (p,), with light motors added to elastic joints without motor inertia."""
    stated = dict(zip(model.names, map(float, values), strict=True))
    lacking = [joint for joint in elastic.tolist() if not stated.get(f"Ia{joint + 1}", 0.0) > 0.0]
    if not lacking:
        return model, values
    inertia = np.maximum(link_size(model)[0], TINY)
    for joint in lacking:
        if f"Ia{joint + 1}" not in stated:
            model = model + RotorInertia((model.robot.joints[joint],))
        stated[f"Ia{joint + 1}"] = LIGHT * float(inertia[joint])
    return model, np.array([stated[name] for name in model.names])


@dataclass(frozen=True, eq=False)
class Thermal:
    r"""First-order warming of each joint alone: :math:`t_c \dot T = T_a + R_{th} (r i^2 + P_f) - T`."""

    ambient: float  # ambient and initial temperature :math:`T_a` [degC]
    rise: np.ndarray  # thermal resistance :math:`R_{th}`, shape (n,) [K/W]; zero for no warming
    resistance: np.ndarray  # winding resistance :math:`r`, shape (n,) [ohm]
    time_constant: float = 1800.0  # time constant :math:`t_c` [s]

    @classmethod
    def constant(cls, joints: int) -> "Thermal":
        """Joints at the constant temperature `AMBIENT`."""
        return cls(AMBIENT, np.zeros(joints), np.zeros(joints))

    def after(
        self, temperature: np.ndarray, current: np.ndarray, friction: np.ndarray, seconds: float
    ) -> np.ndarray:
        """Temperature (n,) [degC] after some time [s] at a current [A] and a friction loss [W]."""
        final = self.ambient + self.rise * (self.resistance * current**2 + friction)
        return final + (temperature - final) * exp(-seconds / self.time_constant)


def random_poses(model: Model) -> np.ndarray:
    """Random poses within the joint range, shape (POSES, n) [rad]."""
    limits = model.robot.limits
    lower, upper = np.maximum(limits.position_lower, -np.pi), np.minimum(limits.position_upper, np.pi)
    return np.random.default_rng(0).uniform(lower, upper, (POSES, model.robot.dof))


def link_size(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Inertia [kg m^2] and load by gravity and 1 rad/s^2 [N m] of each joint, means over poses, each (n,)."""
    kinematics, _ = model.bodies_apart(model.nominal_values, "")
    data, poses = kinematics.createData(), random_poses(model)
    inertia = np.mean([np.diagonal(pin.crba(kinematics, data, pose)) for pose in poses], axis=0)
    weights = [pin.computeGeneralizedGravity(kinematics, data, pose) for pose in poses]
    return inertia, np.mean(np.abs(weights), axis=0) + inertia
