"""Simulated arms, their URDF and MJCF, and right logs of them, from which each mistake is made."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.robot_files.robot_text import urdf_text

from .tables import Known

GYRATION = 0.06
"""Radius of gyration of every body about its centre of mass, relative to the arm's scale [m]."""


class Body(NamedTuple):
    """One moving link, and the joint that carries it."""

    joint: str  # Name of the joint
    parent: str  # Joint whose link carries this joint; "" for the base
    origin: tuple[float, float, float]  # Position of the joint in the parent's link [m]
    axis: tuple[int, int, int]  # Axis of rotation
    mass: float  # Mass of the link [kg]
    center: tuple[float, float, float]  # Its center of mass in the joint's frame [m]


class Arm(NamedTuple):
    """A table of bodies."""

    name: str  # In its files
    bodies: tuple[Body, ...]  # Parents come before their children
    scale: float  # Size of the bodies over that of a six-joint cobot [-]
    middle: tuple[float, ...]  # Posture about which it moves, shape (n,) [rad]
    reach: float = 2.8  # Half of the range of each joint [rad]
    speed: float = 4.0  # Largest permitted speed [rad/s]

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return tuple(body.joint for body in self.bodies)

    def inertia(self, body: Body) -> float:
        """Moment of inertia of a body about each axis through its center of mass [kg m^2]."""
        return body.mass * (GYRATION * self.scale) ** 2

    def urdf(self) -> str:
        """The arm as a URDF."""
        parts = [f'<robot name="{self.name}"><link name="base"/>']
        for body, middle in zip(self.bodies, self.middle, strict=True):
            parent = f"{body.parent}_link" if body.parent else "base"
            limits = f'lower="{middle - self.reach}" upper="{middle + self.reach}"'
            moment = self.inertia(body)
            parts.append(
                f'<joint name="{body.joint}" type="revolute"><parent link="{parent}"/>'
                f'<child link="{body.joint}_link"/><origin xyz="{_text(body.origin)}"/>'
                f'<axis xyz="{_text(body.axis)}"/>'
                f'<limit {limits} velocity="{self.speed}" effort="300"/></joint>'
                f'<link name="{body.joint}_link"><inertial><origin xyz="{_text(body.center)}"/>'
                f'<mass value="{body.mass}"/><inertia ixx="{moment}" iyy="{moment}" izz="{moment}" '
                'ixy="0" ixz="0" iyz="0"/></inertial></link>'
            )
        return "\n".join([*parts, "</robot>"])

    def mjcf(self, servo: str, joint: str) -> str:
        """A serial arm as an MJCF whose servos and joints have these attributes."""
        opened = [
            f'<body pos="{_text(body.origin)}"><joint name="{body.joint}" axis="{_text(body.axis)}" '
            f'range="{middle - self.reach} {middle + self.reach}"/>'
            f'<inertial pos="{_text(body.center)}" mass="{body.mass}" '
            f'diaginertia="{_text([self.inertia(body)] * 3)}"/>'
            for body, middle in zip(self.bodies, self.middle, strict=True)
        ]
        bodies = "".join(opened) + '<site name="tool0"/>' + "</body>" * len(opened)
        servos = "".join(f'<position name="{name}" joint="{name}"/>' for name in self.joints)
        return (
            f'<mujoco model="{self.name}"><compiler angle="radian" autolimits="true"/>'
            f'<option timestep="0.002" integrator="implicitfast"/>'
            f"<default><joint {joint}/><position {servo}/></default>"
            f"<worldbody>{bodies}</worldbody><actuator>{servos}</actuator></mujoco>"
        )

    def loaded(self, mass: float, center: tuple[float, float, float]) -> "Arm":
        """The arm with a point mass at a place of its last link."""
        last = self.bodies[-1]
        total = last.mass + mass
        middle = [(last.mass * a + mass * b) / total for a, b in zip(last.center, center, strict=True)]
        heavier = last._replace(mass=total, center=tuple(middle))
        return self._replace(bodies=(*self.bodies[:-1], heavier))


@cache
def model_of(arm: Arm) -> Model:
    """The arm as its URDF describes it."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        path.write_text(arm.urdf())
        return read_model(path)


def _text(numbers: Sequence[float]) -> str:
    return " ".join(f"{number:.6g}" for number in numbers)


def fourier(
    middle: Sequence[float], time: np.ndarray, seed: int, size: float, period: float = 10.0
) -> Motion:
    """Five harmonics on every joint about a posture (n,), at the times (t,) [s]."""
    rate = 2 * np.pi * np.arange(1, 6) / period
    shape = (2, len(middle), len(rate))
    size = np.random.default_rng(seed).normal(size=shape) * size / (1 + np.arange(len(rate)))
    sine, cosine = np.sin(time[:, None] * rate), np.cos(time[:, None] * rate)
    return Motion.of(
        time,
        np.asarray(middle) + sine @ size[0].T + cosine @ size[1].T,
        cosine @ (size[0] * rate).T - sine @ (size[1] * rate).T,
        -sine @ (size[0] * rate**2).T - cosine @ (size[1] * rate**2).T,
    )


FRICTION, VISCOUS, ROTOR = 0.06, 0.04, 0.01
"""Dry friction as a share of the rms of each joint's torque by its bodies, viscous friction as the same share
at 1 rad/s, and inertia of the rotor at the joint over that of a cobot [kg m^2]."""
NOISE = 0.01
"""Noise of an effort as a share of its standard deviation."""


def torques(arm: Arm, motion: Motion, gravity: bool = True, rotor: float = ROTOR) -> np.ndarray:
    """Torque of bodies, rotors and friction along a motion, with noise, shape (t, n) [N m]."""
    model = model_of(arm)
    rigid = model.torque(motion, model.nominal_values)
    size = np.maximum(np.sqrt((rigid**2).mean(axis=0)), 0.02 * np.abs(rigid).max())
    friction = size * (FRICTION * np.tanh(motion.velocity / 0.01) + VISCOUS * motion.velocity)
    total = rigid + friction + rotor * arm.scale**2 * motion.acceleration
    if not gravity:
        still = Motion.of(motion.time, motion.position, *(np.zeros_like(motion.position),) * 2)
        total = total - model.torque(still, model.nominal_values)
    noise = np.random.default_rng(len(motion)).normal(size=total.shape)
    return total + NOISE * total.std(axis=0) * noise


X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
SIX = Arm(
    "six",
    (
        Body("joint1", "", (0.0, 0.0, 0.16), Z, 7.1, (0.02, -0.03, 0.0)),
        Body("joint2", "joint1", (0.0, 0.18, 0.0), Y, 12.7, (0.0, -0.03, 0.28)),
        Body("joint3", "joint2", (0.0, -0.14, 0.61), Y, 4.3, (0.01, 0.0, 0.25)),
        Body("joint4", "joint3", (0.0, 0.0, 0.57), Y, 2.0, (0.0, 0.09, 0.02)),
        Body("joint5", "joint4", (0.0, 0.16, 0.0), Z, 2.0, (0.01, 0.0, 0.08)),
        Body("joint6", "joint5", (0.0, 0.0, 0.12), Y, 0.6, (0.02, 0.05, 0.01)),
    ),
    1.0,
    (0.0, 0.6, 0.9, 0.2, 0.0, 0.0),
)
SERVO = Arm(
    "servo_arm",
    (
        Body("shoulder_pan", "", (0.0, 0.0, 0.06), Z, 0.12, (0.0, 0.0, 0.03)),
        Body("shoulder_lift", "shoulder_pan", (0.03, 0.0, 0.05), Y, 0.12, (0.0, 0.0, 0.06)),
        Body("elbow_flex", "shoulder_lift", (0.03, 0.0, 0.11), Y, 0.10, (0.06, 0.0, 0.0)),
        Body("wrist_flex", "elbow_flex", (0.135, 0.0, 0.0), Y, 0.09, (0.03, 0.0, 0.0)),
        Body("wrist_roll", "wrist_flex", (0.06, 0.0, 0.0), X, 0.12, (0.04, 0.008, 0.0)),
    ),
    0.3,
    (0.1, 0.0, 0.2, -0.1, 0.3),
    reach=1.8,
    speed=5.0,
)


def _leg(leg: str, x: float, y: float) -> tuple[Body, ...]:
    side = np.sign(y)
    return (
        Body(f"{leg}_hip", "", (x, y, 0.0), X, 0.68, (-0.005 * np.sign(x), 0.002 * side, 0.0)),
        Body(f"{leg}_thigh", f"{leg}_hip", (0.0, 0.0955 * side, 0.0), Y, 1.15, (-0.004, -0.02 * side, -0.03)),
        Body(f"{leg}_calf", f"{leg}_thigh", (0.0, 0.0, -0.213), Y, 0.24, (0.005, 0.001 * side, -0.13)),
    )


LEGS = Arm(
    "quadruped",
    (
        *_leg("FL", 0.19, 0.047),
        *_leg("FR", 0.19, -0.047),
        *_leg("RL", -0.19, 0.047),
        *_leg("RR", -0.19, -0.047),
    ),
    0.5,
    (0.0, 0.9, -1.7) * 4,
    speed=12.0,
)


@dataclass(frozen=True)
class Samples:
    """A run in SI: time (t,), the rest (t, n); velocity is None where it was not recorded."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray | None
    effort: np.ndarray
    joints: tuple[str, ...]
    robot: str
    gain: np.ndarray | None

    @property
    def dof(self) -> int:
        """Number of joints."""
        return self.position.shape[1]


@cache
def simulated() -> Samples:
    """Half a minute of the built-in cobot at 500 Hz: encoders of 19 bits, 2 % noise of current, friction."""
    model = read_model("cobot")
    rng, n = np.random.default_rng(3), model.robot.dof
    time = np.arange(15000) / 500.0
    middle = [0.0, -1.5, 0.5, -1.0, 0.5, 0.0]
    motion = fourier(middle, time, 3, 0.35)
    rng.normal(size=(2, n, 5))  # the numbers of that motion
    position = motion.position
    current = model.torque(model.loaded(motion), model.nominal_values) / model.robot.drive_gain
    current += 0.02 * current.std(axis=0) * rng.normal(size=current.shape)
    step = 2 * np.pi / 2**19
    position = np.round(position / step) * step
    gain = model.robot.drive_gain
    return Samples(time, position, motion.velocity, current, model.robot.joints, urdf_text(model), gain)


Columns = dict[str, np.ndarray]
"""Samples of a log by the names of its columns, each of shape (t,)."""
EVERY = 5
"""Samples of the simulated cobot, 500 Hz, of which one is written."""
COUNTS = 4096
"""Steps of a servo's encoder in a turn."""
KP = 17.8
"""Torque of the servo arm's servos for each radian between command and position [N m/rad]."""


@dataclass(frozen=True)
class Scene:
    """A right log of an arm."""

    columns: Columns  # The log
    known: Known  # What is true of it
    arm: str  # The arm's URDF or MJCF
    robot: str  # robot.toml of the import; "" for `arm`; or the name of a built-in robot
    joints: tuple[str, ...]  # Names of the joints
    effort: str = ""  # Option --effort of import

    @property
    def suffix(self) -> str:
        """Suffix of the file of `arm`."""
        return ".xml" if self.arm.startswith("<mujoco") else ".urdf"


def numbered(**signals: np.ndarray) -> Columns:
    """Columns t and others, whose joints are numbered from 1; time is (t,), the others are (t, n)."""
    columns = {"t": signals.pop("t")}
    for name, values in signals.items():
        columns |= {f"{name}{joint + 1}": values[:, joint].copy() for joint in range(values.shape[1])}
    return columns


def _known(dof: int, effort: str, column: str, gain: np.ndarray | None, velocity: str = "") -> Known:
    names = {"position": "q", effort: column}
    columns = {signal: [f"{name}{j + 1}" for j in range(dof)] for signal, name in names.items()}
    return Known("s", "rad", velocity, effort, gain, {"time": ["t"], **columns})


@cache
def cobot() -> Scene:
    """Half a minute of the built-in cobot with currents, at 100 Hz, whose drive gains robot.toml states."""
    run = simulated()
    velocity = np.gradient(run.position, run.time, axis=0)
    rows = slice(None, None, EVERY)
    columns = numbered(t=run.time[rows], q=run.position[rows], dq=velocity[rows], i=run.effort[rows])
    known = _known(run.dof, "current", "i", run.gain, "rad")
    return Scene(columns, known, run.robot, "cobot", run.joints)


def joint_torques(
    arm: Arm, seconds: float, rate: float, size: float, seed: int, gravity: bool = True
) -> Scene:
    """A log of joint torques of an arm."""
    motion = fourier(arm.middle, np.arange(0.0, seconds, 1 / rate), seed, size)
    columns = numbered(t=motion.time, q=motion.position, tau=torques(arm, motion, gravity))
    known = _known(len(arm.bodies), "torque", "tau", np.ones(len(arm.bodies)))
    return Scene(columns, known, arm.urdf(), "", arm.joints)


@cache
def six() -> Scene:
    """Half a minute of a six-joint arm with joint torques, at 100 Hz."""
    return joint_torques(SIX, 30.0, 100.0, 0.35, seed=3)


@cache
def legs() -> Scene:
    """A quadruped whose trunk hangs, with joint torques: 1,000 samples of twelve joints."""
    return joint_torques(LEGS, 10.0, 100.0, 0.25, seed=5)


def followed(seed: int, seconds: float = 40.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (t,), positions and commands (t, n) of the servo arm, whose servos hold q by kp alone."""
    motion = fourier(SERVO.middle, np.arange(0.0, seconds, 0.02), seed, 0.3)
    command = motion.position + torques(SERVO, motion, rotor=0.2) / KP
    step = 2 * np.pi / COUNTS
    return motion.time, *(np.round(values / step) * step for values in (motion.position, command))


SERVO_TOML = f"""format = 1
urdf = "arm.urdf"
[drive]
gain = {KP}
servo_gain = 1
"""


@cache
def servos() -> Scene:
    """A servo arm without effort: positions and commands, 50 Hz."""
    time, position, command = followed(seed=2)
    n = position.shape[1]
    known = _known(n, "command", "q_ref", np.full(n, KP))
    columns = numbered(t=time, q=position, q_ref=command)
    return Scene(columns, known, SERVO.urdf(), SERVO_TOML, SERVO.joints, "command")


SCENES: dict[str, Callable[[], Scene]] = {"cobot": cobot, "six": six, "legs": legs, "servos": servos}
"""Right logs by name."""
