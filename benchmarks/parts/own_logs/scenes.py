"""Right logs of simulated arms, from which each mistake is made."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from exidyn.identification.robot_files.robot_file import read_model

from .arms import LEGS, SERVO, SIX, Arm, fourier, torques
from .logs import simulated
from .sets import Known

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
    # robot.toml by which it is imported; "" to import it by `arm`, or the name of a built-in robot
    robot: str
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


def built_in_urdf(name: str) -> str:
    """A built-in robot as a URDF."""
    from exidyn.identification.robot_files.robot_text import urdf_text

    return urdf_text(read_model(name))
