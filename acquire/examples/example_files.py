"""Examples: files such as a person has, of a simulated arm with a log, and of one of servos with its MJCF."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path

import numpy as np

from exidyn.identification.arm.robot import Limits, PositionServo
from exidyn.identification.effects import LoadDependentFriction, Payload, Prior, known_parameters
from exidyn.identification.model import Model
from exidyn.identification.robot_files.commented import commented_text
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import as_built, simulate
from exidyn.identification.text_table import table
from exidyn.trajectories.random_motion import random_fourier

from .example_runs import LOADED, NOMINAL, TRUTH, ExampleArm

LOG, ARM = "log.csv", "arm.xml"
RATE, SECONDS = 250.0, 20.0
"""Sampling rate [Hz] and duration [s] of the log."""
STIFFNESS, STRENGTH = 17.8, 3.35
"""Stiffness [N m/rad] and largest torque [N m] of each servo: an STS3215 with P = 16 at 12 V."""
TERMS = {"Ia": 0.028, "Fv": 0.6, "Fc": 0.05}
"""Published rotor inertia [kg m^2], viscous [N m s/rad] and Coulomb friction [N m] of each servo."""
BY_LOAD = ("shoulder_lift", "elbow_flex", "wrist_flex"), 0.2
"""Joints with load-dependent friction, and its share of the torque in the gear [-]."""
MASS, CENTER = 0.25, (0.02, 0.06, 0.0)
"""Mass [kg] and center of mass in the flange frame [m] of the payload of the loaded arm."""
SHORT = f"""# Known before any measurement: the MJCF, the limits of the motion, and the drives.
format = 1
name = "servo_arm"
mjcf = "{ARM}"

[limits]
velocity = 2.5                  # rad/s
acceleration = 12.0             # rad/s^2
jerk = 200.0                    # rad/s^3

[drive]
servo_gain = 1                  # position servos: the position error replaces the current
gain = 17.8                     # kp [N m/rad], as published for these servos; the 50 of the MJCF is a choice
gain_tolerance = 0.15           # relative tolerance of each servo's gain
servo_limit = 0.19              # position error at which the servos saturate at 3.35 N m
"""
WITH_LOG = {
    NOMINAL: "nominal values of the arm, as a manufacturer states them",
    LOG: "log of the arm: time [s], positions [degrees], motor currents [A]",
    TRUTH: "true values of the simulated arm, for comparison",
}
OF_SERVOS = {
    ARM: "MJCF of the arm, as its owner uses it for simulations",
    NOMINAL: "limits and servo drives of the arm, for exidyn",
    TRUTH: "true values of the simulated arm, for comparison",
    LOADED: f"the true arm with a payload of {MASS:g} kg",
}
"""Written files, which do not overwrite existing ones, and their contents."""


def file_table(contents: Mapping[str, str], folder: Path) -> str:
    """Table of the files in a folder and their contents."""
    rows = [[str(folder / name), content] for name, content in contents.items()]
    return "\n".join(table(["file", "content"], rows, left=(0, 1)))


@dataclass(frozen=True)
class ArmWithLog(ExampleArm):
    """An arm with a log of an unplanned motion, in degrees and amperes."""

    def files(self) -> Mapping[str, str]:
        """Robot files, name -> text; this arm has no payload."""
        return {name: text for name, text in super().files().items() if name in WITH_LOG}

    def write(self, folder: Path) -> None:
        """Write the robot files and the log into a folder."""
        super().write(folder)
        motion = random_fourier(self.nominal.robot.limits, SECONDS).at(np.arange(0.0, SECONDS, 1.0 / RATE))
        truth = self.truth
        run = simulate(truth, truth.nominal_values, truth.robot.drive_gain, motion, self.nominal)
        position, current = run.signals["position"], run.signals["current"]
        rows = np.column_stack([position.time, np.degrees(position.values), current.values])
        joints = range(1, truth.robot.dof + 1)
        names = ",".join(["t", *(f"{letter}{joint}" for letter in "qi" for joint in joints)])
        np.savetxt(folder / LOG, rows, "%.6f", ",", header=names, comments="")


def arm_with_log() -> ExampleArm:
    """A collaborative arm as built, and with the manufacturer's values."""
    nominal = read_model("cobot")
    return ArmWithLog(as_built(nominal), nominal)


@dataclass(frozen=True)
class ServoArm(ExampleArm):
    """An arm that is described by an MJCF and a short robot.toml, as a person would write it."""

    def files(self) -> Mapping[str, str]:
        """The MJCF, robot.toml, and the true arm without and with a payload, name -> text."""
        models = {TRUTH: self.truth, LOADED: self.truth + Payload("L", known_parameters(MASS, CENTER))}
        text = {name: commented_text(model) for name, model in models.items()}
        return {ARM: described(), NOMINAL: SHORT} | text


def described() -> str:
    """Text of the MJCF."""
    return resources.files(__package__).joinpath("servo_arm.xml").read_text("utf-8")


def servo_arm() -> ExampleArm:
    """The true arm, and the arm of its MJCF."""
    with resources.as_file(resources.files(__package__).joinpath("servo_arm.xml")) as path:
        nominal = read_model(path)
    return ServoArm(_real(nominal), nominal)


def _real(nominal: Model) -> Model:
    """The true arm: masses off by up to their tolerance, with true servos and friction."""
    limits, n = nominal.robot.limits, nominal.robot.dof
    stiffness = np.full(n, STIFFNESS)
    servo = PositionServo(np.ones(n), np.full(n, STRENGTH / STIFFNESS))
    unlimited, torque = np.full(n, np.inf), np.full(n, STRENGTH)
    limits = Limits(
        limits.position_lower, limits.position_upper, np.full(n, 4.0), unlimited, unlimited, torque
    )
    joints, share = BY_LOAD
    friction = LoadDependentFriction(joints)
    names = [parameter.name for effect in nominal.effects for parameter in effect.parameters(nominal.robot)]
    stated = {name: Prior(value) for name in names for key, value in TERMS.items() if name.startswith(key)}
    stated |= {parameter.name: Prior(share) for parameter in friction.parameters(nominal.robot)}
    robot = replace(
        nominal.robot, limits=limits, servo=servo, drive_gain=stiffness, drive_gain_tolerance=np.full(n, 0.1)
    )
    return as_built(Model(robot, (*nominal.effects, friction), stated))
