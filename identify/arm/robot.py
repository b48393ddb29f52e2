"""`Robot`: kinematics, nominal inertias, limits and drives of one arm; `ServoLaw`, the law of its servos."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pinocchio as pin

from ..errors import BrokenTree, UnknownJoint, WrongShape
from .body_units import BodyUnits, body_units
from .newton_euler import joints_of

CALIBRATED = 0.02
"""Largest change of a joint's position [m] or axes [rad] by a calibration; different arms differ more."""
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
"""Unit for a revolute joint -> unit for a prismatic joint."""
FLANGE = "[flange]"
"""Name of a flange frame that a robot file states, such as in its table [flange], without a name."""
Held = Mapping[str, float | tuple[float, ...]]
"""Joints that do not move, and their positions: [rad, m], or several numbers for a free joint or a ball."""


def _not_given() -> np.ndarray:
    return np.empty(0)


@dataclass(frozen=True)
class Limits:
    """Joint limits; infinite if not given."""

    position_lower: np.ndarray  # lower position limit, shape (n,) [rad] or [m]
    position_upper: np.ndarray  # upper position limit, shape (n,) [rad] or [m]
    velocity: np.ndarray  # upper velocity limit, shape (n,) [rad/s]
    acceleration: np.ndarray  # upper acceleration limit, shape (n,) [rad/s^2]
    jerk: np.ndarray  # jerk limit, shape (n,) [rad/s^3]
    torque: np.ndarray  # torque limit, shape (n,) [N m]
    # Lower velocity limit, negative, shape (n,) [rad/s]; minus `velocity` by default.
    velocity_lower: np.ndarray = field(default_factory=_not_given)
    # Lower acceleration limit, negative, shape (n,) [rad/s^2]; minus `acceleration` by default.
    acceleration_lower: np.ndarray = field(default_factory=_not_given)

    def __post_init__(self) -> None:
        for name in ("velocity", "acceleration"):
            if getattr(self, f"{name}_lower").size == 0:
                object.__setattr__(self, f"{name}_lower", -np.asarray(getattr(self, name), float))

    @classmethod
    def none(cls, joints: int) -> "Limits":
        """Infinite limits of `joints` joints."""
        far = np.full(joints, np.inf)
        return cls(-far, far, far, far, far, far)


@dataclass(frozen=True)
class PositionServo:
    """Position servos: torque is the drive gain times gain times position error, up to a limit."""

    gain: np.ndarray  # factor of the position error before the drive gain, such as a register, shape (n,) [-]
    # Position error times `gain` at which the torque saturates, shape (n,) [rad]; infinite if not stated.
    limit: np.ndarray


@dataclass(frozen=True)
class Robot:
    """One arm with its nominal parameters."""

    name: str  # name of the robot
    kinematics: pin.Model  # pinocchio model with one degree of freedom per joint and the nominal inertias
    limits: Limits = field(default_factory=lambda: Limits.none(0))  # joint limits
    # Joint torque per motor current, signed, shape (n,) [N m/A].
    drive_gain: np.ndarray = field(default_factory=_not_given)
    # Relative standard deviation of each drive gain, shape (n,) [-]; a single number applies to all.
    drive_gain_tolerance: np.ndarray = field(default_factory=lambda: np.array(0.1))
    # Whether true gains are certainly within sqrt(3) of these standard deviations.
    drive_gain_bounded: bool = False
    inertial_tolerance: float = 0.1  # relative standard deviation of the nominal inertias [-]
    # Whether nominal inertias were identified from currents with the nominal gains, so that both have the
    # same relative error.
    inertias_by_gain: bool = False
    # Whether the robot file states the tolerance of the inertias; a bare URDF does not.
    inertias_stated: bool = True
    gear_ratio: np.ndarray = field(default_factory=_not_given)  # motor turns per joint turn, shape (n,) [-]
    # Names of joints whose motor has no gear, and so no elasticity or play.
    direct_drive: tuple[str, ...] = ()
    # Names of joints without a motor: their torque is zero, regardless of measurements.
    passive: tuple[str, ...] = ()
    # Control law of position servos, used to read a log without current; None for other drives.
    servo: PositionServo | None = None
    # Matrix of the paper's (22) with unit diagonal: motor velocity over gear ratio = coupling @ joint
    # velocity, shape (n, n) [-].
    coupling: np.ndarray = field(default_factory=_not_given)
    # Placement of the flange in the frame of the last link; the frame of payloads.
    flange: pin.SE3 = field(default_factory=pin.SE3.Identity)
    flange_name: str = FLANGE  # name of the flange's frame in the description
    # Other joints of the described arm that are held away from their reference, and their positions. The
    # simulation of its MJCF holds them there too.
    held: Held = field(default_factory=dict)

    def __post_init__(self) -> None:
        n = self.kinematics.nv
        if n == 0 or self.kinematics.nq != n:
            raise BrokenTree(
                f"{self.name}: {self.kinematics.nq} positions for {n} velocities; every joint must be "
                "revolute or prismatic, and there must be at least one"
            )
        defaults = {"drive_gain": np.ones(n), "gear_ratio": np.ones(n), "coupling": np.eye(n)}
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
        """Joint names, in the order of all (t, n) arrays."""
        return tuple(self.kinematics.names)[1:]

    @cached_property
    def revolute(self) -> np.ndarray:
        """Whether each joint is revolute; the others are prismatic. Shape (n,), bool."""
        return np.array([joint.revolute for joint in joints_of(self.kinematics)])

    @cached_property
    def body_units(self) -> BodyUnits:
        """Whether the described masses and inertias are plausible."""
        return body_units(self.kinematics)

    @property
    def geared(self) -> np.ndarray:
        """Whether each joint has a gear, shape (n,), bool."""
        return ~np.isin(self.joints, self.direct_drive)

    def units(self, turning: str) -> tuple[str, ...]:
        """Unit for each joint, from the unit for revolute joints."""
        return tuple(turning if revolute else SLIDING.get(turning, turning) for revolute in self.revolute)

    def unit(self, joint: int, turning: str) -> str:
        """Unit for one joint, by its index, from the unit for revolute joints."""
        return turning if self.revolute[joint] else SLIDING.get(turning, turning)

    def index(self, joint: str) -> int:
        """Index of a joint.

        Raises:
            UnknownJoint: The robot has no joint of that name.
        """
        if joint not in self.joints:
            raise UnknownJoint(joint, self.name, self.joints)
        return self.joints.index(joint)

    def differs_from(self, other: "Robot") -> bool:
        """Whether another robot with the same joint names has another name and other geometry.

        Either alone may differ for one arm: robot files are renamed, and geometry is calibrated.
        """
        pairs = zip(self.kinematics.jointPlacements, other.kinematics.jointPlacements, strict=True)
        close = (np.allclose(a.homogeneous, b.homogeneous, rtol=0.0, atol=CALIBRATED) for a, b in pairs)
        return self.name != other.name and not all(close)

    @property
    def to_motors(self) -> np.ndarray:
        """Matrix for motor torque times gear ratio = to_motors @ joint torque, shape (n, n) [-]."""
        return np.linalg.inv(self.coupling).T

    @property
    def gravity(self) -> np.ndarray:
        """Gravity in the base frame, shape (3,) [m/s^2]."""
        return np.array(self.kinematics.gravity.linear)


@dataclass(frozen=True, eq=False)
class ServoLaw:
    r"""Law of the position servos of n joints: the torque that a servo exerts for a command c.

    .. math:: \tau = \mathrm{clip}\left(k_p (c(t - d) - q) - k_v \dot q + k_f \dot c(t - d)
        + k_i \int (c(t - d) - q)\, dt,\; \pm L\right)
    """

    stiffness: np.ndarray  # torque per position error k_p, shape (n,) [N m/rad]
    damping: np.ndarray  # torque against the joint's velocity k_v, shape (n,) [N m s/rad]
    limit: np.ndarray  # largest torque L, shape (n,) [N m]; infinite if there is none
    delay: np.ndarray  # time d from a command to its effect, shape (n,) [s]
    feed_forward: np.ndarray  # torque per commanded velocity k_f, shape (n,) [N m s/rad]
    integral: np.ndarray  # torque per integrated position error k_i, shape (n,) [N m/(rad s)]

    @classmethod
    def of(
        cls, stiffness: np.ndarray, damping: np.ndarray, limit: np.ndarray, delay: np.ndarray
    ) -> "ServoLaw":
        """Servos without feed-forward and integral."""
        return cls(stiffness, damping, limit, delay, *np.zeros((2, len(stiffness))))
