"""The arms that every excitation tool is given, and the judge of what they hand back.

UR10 (36 base columns) and xArm 7 (43) of the package example-robot-data, rigid bodies only. Every tool keeps
to the same limits: those of the URDF less a tenth of their range at either end, which is what FIGAROH's UR10
example keeps clear of.
"""

import importlib.metadata
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import RigidBody
from exidyn.identification.fit.base_parameters import BaseParameters, base_parameters
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model

PACKAGE = "example-robot-data"
MARGIN = 0.1
"""Share of a limit's range that is kept clear at either end; FIGAROH's UR10 example does so."""
ALLOWED = 0.03
"""Share of a limit by which a trajectory may exceed it and still count. FIGAROH takes its margin in two
steps and so goes 2.5 % further on the negative side; the rest is what passes between samples of a grid."""
RATE = 100.0
"""Samples a second at which a trajectory is judged [Hz]."""


class States(NamedTuple):
    """A trajectory as sampled, each of shape (t, n); [rad], [rad/s], [rad/s^2]."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


class Verdict(NamedTuple):
    """Verdict of the judge on a trajectory."""

    condition: float  # Condition number of the base regressor, columns scaled to unit length [-]
    excess: float  # Worst excess over a limit as a share of it; not above 0 where all are kept [-]
    where: str  # Which limit of which joint that is


@dataclass(frozen=True, eq=False)
class Arm:
    """One arm for all tools."""

    name: str  # What to call it
    model: Model  # Robot and rigid bodies
    urdf: Path  # File of the robot
    packages: Path  # Folder in which the mesh files named in it are found
    margin: float  # Share of each limit's range that is kept clear at either end
    limits: Limits  # Position, velocity and torque that every tool keeps to, the margin taken off
    base: BaseParameters  # Which columns remain

    @property
    def dof(self) -> int:
        """Number of joints n."""
        return self.model.robot.dof

    def base_regressor(self, states: States) -> np.ndarray:
        """Base columns, shape (t n, b)."""
        time = np.arange(len(states.position)) / RATE  # rigid bodies do not ask for it
        columns = self.model.regressor(Motion.of(time, *states))
        return columns.reshape(-1, columns.shape[2])[:, self.base.kept]

    def condition(self, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray) -> float:
        """Condition number of the base regressor with unit columns; each of shape (t, n)."""
        return unit_condition(self.base_regressor(States(position, velocity, acceleration)))

    def torque(self, states: States) -> np.ndarray:
        """Inverse dynamics by Pinocchio, shape (t, n) [N m]."""
        kinematics = self.model.robot.kinematics
        data = kinematics.createData()
        return np.array([pin.rnea(kinematics, data, *row) for row in zip(*states, strict=True)])

    def judge(self, states: States) -> Verdict:
        """Condition number and violations of a trajectory, sampled densely over its whole length."""
        return Verdict(unit_condition(self.base_regressor(states)), *self._worst(states))

    def _worst(self, states: States) -> tuple[float, str]:
        limits, zero = self.limits, np.zeros(self.dof)
        middle = 0.5 * (limits.position_lower + limits.position_upper)
        half = 0.5 * (limits.position_upper - limits.position_lower)
        kinds = {
            "position": (states.position, middle, half),
            "velocity": (states.velocity, zero, limits.velocity),
            "torque": (self.torque(states), zero, limits.torque),
        }
        over = {
            f"{kind} of {joint}": float(share)
            for kind, (value, centre, most) in kinds.items()
            for joint, share in zip(
                self.model.robot.joints, np.max(np.abs(value - centre), axis=0) / most - 1.0, strict=True
            )
        }
        where = max(over, key=lambda name: over[name])
        return over[where], where


def unit_condition(columns: np.ndarray) -> float:
    """Condition number of a matrix whose columns are scaled to unit length."""
    return float(np.linalg.cond(columns / np.linalg.norm(columns, axis=0)))


def why_no_arm() -> str:
    """Sentence with the reason why there are no arms; empty where they are."""
    try:
        importlib.metadata.distribution(PACKAGE)
    except importlib.metadata.PackageNotFoundError as missing:
        return f"The UR10 is not there ({missing}); pip install 'exidyn[bench]' brings it."
    return ""


def robots() -> Path:
    """Folder of the package's robots."""
    return packages() / PACKAGE / "robots"


def packages() -> Path:
    """Folder in which the mesh files named in them are found."""
    if absent := why_no_arm():
        raise ImportError(absent)
    return Path(str(importlib.metadata.distribution(PACKAGE).locate_file("cmeel.prefix/share")))


ARMS = {"UR10": "ur_description/urdf/ur10_robot.urdf", "xArm 7": "xarm_description/urdf/xarm7.urdf"}
"""Arms for all tools."""


def arm_of(name: str, margin: float = MARGIN) -> Arm:
    """An arm of `ARMS`; `margin` is the share of each limit's range to keep clear at either end."""
    urdf = robots() / ARMS[name]
    model = replace(read_model(urdf), effects=(RigidBody(),))
    limits = _within(model.robot.limits, margin)
    return Arm(name, model, urdf, packages(), margin, limits, base_parameters(model))


def _within(limits: Limits, margin: float) -> Limits:
    clear = margin * (limits.position_upper - limits.position_lower)
    share = 1.0 - 2.0 * margin
    return replace(
        limits,
        position_lower=limits.position_lower + clear,
        position_upper=limits.position_upper - clear,
        velocity=share * limits.velocity,
        velocity_lower=share * limits.velocity_lower,
        torque=share * limits.torque,
    )
