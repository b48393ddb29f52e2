"""Robot: kinematics, nominal inertias, limits and drives of one arm."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pinocchio as pin

from ..errors import BrokenTree, UnknownJoint, WrongShape
from .newton_euler import joints_of

SLIDING = {
    "rad": "m",
    "rad/s": "m/s",
    "rad/s²": "m/s²",
    "rad/s^2": "m/s^2",
    "N m": "N",
    "N m/K": "N/K",
    "N m/A": "N/A",
    "N m s/rad": "N s/m",
    "N m s/rad/K": "N s/m/K",
    "N m/rad": "N/m",
    "N m/rad^2": "N/m^2",
    "N m/rad^3": "N/m^3",
    "kg m^2": "kg",
    "rad/(N m)": "m/N",
}
"""Unit of a revolute joint -> that of a prismatic one."""


def _not_given() -> np.ndarray:
    return np.empty(0)


@dataclass(frozen=True)
class Limits:
    """What the arm may do; infinite where not given.

    Attributes:
        position_lower: Shape (n,) [rad] or [m].
        position_upper: Shape (n,) [rad] or [m].
        velocity: Shape (n,) [rad/s].
        acceleration: Shape (n,) [rad/s^2].
        jerk: Shape (n,) [rad/s^3].
        torque: Shape (n,) [N m].
        velocity_lower: Shape (n,) [rad/s], negative; minus `velocity` unless given.
        acceleration_lower: Shape (n,) [rad/s^2], negative; minus `acceleration` unless given.
    """

    position_lower: np.ndarray
    position_upper: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray
    torque: np.ndarray
    velocity_lower: np.ndarray = field(default_factory=_not_given)
    acceleration_lower: np.ndarray = field(default_factory=_not_given)

    def __post_init__(self) -> None:
        for name in ("velocity", "acceleration"):
            if getattr(self, f"{name}_lower").size == 0:
                object.__setattr__(self, f"{name}_lower", -np.asarray(getattr(self, name), float))

    @classmethod
    def none(cls, joints: int) -> "Limits":
        """No limit on any of `joints` joints."""
        far = np.full(joints, np.inf)
        return cls(-far, far, far, far, far, far)


@dataclass(frozen=True)
class PositionServo:
    """Drives whose torque is the drive gain times what is left to their command, up to a limit.

    Attributes:
        gain: By which that error is multiplied before the drive gain, shape (n,) [-], as a register.
        limit: Error, `gain` included, from which on a servo gives all it can, shape (n,) [rad]; infinite
            where none is stated.
    """

    gain: np.ndarray
    limit: np.ndarray


@dataclass(frozen=True)
class Robot:
    """One arm with its nominal parameters.

    Attributes:
        name: What people call it.
        kinematics: Pinocchio model with one degree of freedom a joint and the nominal inertias.
        limits: Joint limits.
        drive_gain: Joint torque per motor current, signed, shape (n,) [N m/A].
        drive_gain_tolerance: Relative standard deviation of each drive gain, shape (n,) [-]; one number
            stands for all.
        drive_gain_bounded: Whether true gains are certain to be within the square root of three of these.
        inertial_tolerance: Relative standard deviation of the nominal inertias [-].
        inertias_by_gain: Whether nominal inertias were identified from currents with the nominal gains, so
            that both are wrong together.
        inertias_stated: Whether the robot file states how well they are known; a bare URDF does not.
        gear_ratio: Motor turns per joint turn, shape (n,) [-].
        direct_drive: Joints whose motor has no gear that could bend or have play.
        passive: Joints without a motor: their torque is zero, whatever was measured.
        servo: Law of its drives where these are position servos, by which a log without current is read; None
            for other drives.
        coupling: Motor velocity over gear ratio = coupling @ joint velocity, the paper's (22) with
            unit diagonal, shape (n, n) [-].
        flange: Placement of the flange in the last link's frame; payloads are given in it.
    """

    name: str
    kinematics: pin.Model
    limits: Limits = field(default_factory=lambda: Limits.none(0))
    drive_gain: np.ndarray = field(default_factory=_not_given)
    drive_gain_tolerance: np.ndarray = field(default_factory=lambda: np.array(0.1))
    drive_gain_bounded: bool = False
    inertial_tolerance: float = 0.1
    inertias_by_gain: bool = False
    inertias_stated: bool = True
    gear_ratio: np.ndarray = field(default_factory=_not_given)
    direct_drive: tuple[str, ...] = ()
    passive: tuple[str, ...] = ()
    servo: PositionServo | None = None
    coupling: np.ndarray = field(default_factory=_not_given)
    flange: pin.SE3 = field(default_factory=pin.SE3.Identity)

    def __post_init__(self) -> None:
        n = self.kinematics.nv
        if n == 0 or self.kinematics.nq != n:
            raise BrokenTree(
                f"{self.name}: {self.kinematics.nq} positions for {n} velocities; every joint must be "
                "revolute or prismatic, and there must be at least one"
            )
        defaults = {
            "drive_gain": np.ones(n),
            "gear_ratio": np.ones(n),
            "coupling": np.eye(n),
        }
        for name, default in defaults.items():
            value = np.asarray(getattr(self, name), float)
            value = default if value.size == 0 else value
            if value.shape != default.shape:
                raise WrongShape(f"{self.name}: {name} has shape {value.shape}, expected {default.shape}")
            object.__setattr__(self, name, value)
        object.__setattr__(self, "drive_gain_tolerance", np.zeros(n) + self.drive_gain_tolerance)
        if self.limits.velocity.size == 0:
            object.__setattr__(self, "limits", Limits.none(n))
        for joint in (*self.direct_drive, *self.passive):
            self.index(joint)

    @property
    def dof(self) -> int:
        """Number of joints n."""
        return int(self.kinematics.nv)

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """Joint names, in the order of every (t, n) array."""
        return tuple(self.kinematics.names)[1:]

    @cached_property
    def revolute(self) -> np.ndarray:
        """Which joints are revolute; the others are prismatic. Shape (n,), bool."""
        return np.array([joint.revolute for joint in joints_of(self.kinematics)])

    @property
    def geared(self) -> np.ndarray:
        """Which joints have a gear, shape (n,), bool."""
        return ~np.isin(self.joints, self.direct_drive)

    def units(self, turning: str) -> tuple[str, ...]:
        """A unit for each joint, given that of revolute joints."""
        return tuple(turning if revolute else SLIDING.get(turning, turning) for revolute in self.revolute)

    def unit(self, joint: int, turning: str) -> str:
        """The unit of one joint, by its column, given that of revolute joints."""
        return turning if self.revolute[joint] else SLIDING.get(turning, turning)

    def index(self, joint: str) -> int:
        """Column of a joint.

        Raises:
            UnknownJoint: The robot has no joint of that name.
        """
        if joint not in self.joints:
            raise UnknownJoint(joint, self.name, self.joints)
        return self.joints.index(joint)

    @property
    def to_motors(self) -> np.ndarray:
        """Motor torque times gear ratio = to_motors @ joint torque, by virtual work; shape (n, n) [-]."""
        return np.linalg.inv(self.coupling).T

    @property
    def gravity(self) -> np.ndarray:
        """Gravity in the base frame, shape (3,) [m/s^2]."""
        return np.array(self.kinematics.gravity.linear)
