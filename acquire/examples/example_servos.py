"""Example: an arm of position servos without current, and the MJCF that its owner has."""

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
from exidyn.identification.simulation.simulate import as_built
from exidyn.identification.text_table import table

from .example_arm import LOADED, NOMINAL, TRUTH, ExampleArm, Step

ARM = "arm.xml"
FILES = (ARM, NOMINAL, TRUTH, LOADED)
"""What is written, and not over a person's own."""
STIFFNESS, STRENGTH = 17.8, 3.35
"""Of each servo [N m/rad], [N m], as an STS3215 has them at a P of 16 and 12 V."""
TERMS = {"Ia": 0.028, "Fv": 0.6, "Fc": 0.05}
"""Inertia of rotor and gear [kg m^2], drag [N m s/rad], dry friction [N m] of each, as published of it."""
BY_LOAD = ("shoulder_lift", "elbow_flex", "wrist_flex"), 0.2
"""Joints whose friction grows with the torque that the gears carry, and the share of it [-]."""
MASS, CENTRE = 0.25, (0.02, 0.06, 0.0)
"""Of the body that the loaded arm holds [kg], [m] from its flange."""
SHORT = f"""# What is known before anything is measured: the MJCF, how fast the arm may move, what drives it.
format = 1
name = "servo_arm"
mjcf = "{ARM}"

[limits]
velocity = 2.5                  # rad/s
acceleration = 12.0             # rad/s^2
jerk = 200.0                    # rad/s^3

[drive]
servo_gain = 1                  # position servos: what is left to the command stands for the current
gain = 17.8                     # then kp [N m/rad]: as published of these servos; the file's 50 is a choice
gain_tolerance = 0.15           # how far each servo's may be off
servo_limit = 0.19              # error at which they give all they can: 3.35 N m
"""


@dataclass(frozen=True)
class ServoArm(ExampleArm):
    """An arm that is described by an MJCF; its robot.toml is what a person writes beside that."""

    def files(self) -> Mapping[str, str]:
        """The MJCF, robot.toml, and what the arm is, without and with a body; name -> text."""
        models = {TRUTH: self.truth, LOADED: self.truth + Payload("L", known_parameters(MASS, CENTRE))}
        text = {name: commented_text(model) for name, model in models.items()}
        return {ARM: described(), NOMINAL: SHORT} | text


def described() -> str:
    """The MJCF."""
    return resources.files(__package__).joinpath("servo_arm.xml").read_text("utf-8")


def arm() -> ExampleArm:
    """The arm as its file describes it, and as it is."""
    with resources.as_file(resources.files(__package__).joinpath("servo_arm.xml")) as path:
        nominal = read_model(path)
    return ServoArm(_real(nominal), nominal)


def _real(nominal: Model) -> Model:
    """Masses off by up to their tolerance, servos and friction as they are."""
    limits, n = nominal.robot.limits, nominal.robot.dof
    stiffness = np.full(n, STIFFNESS)
    servo = PositionServo(np.ones(n), np.full(n, STRENGTH / STIFFNESS))
    free = np.full(n, np.inf)
    limits = Limits(
        limits.position_lower, limits.position_upper, np.full(n, 4.0), free, free, np.full(n, STRENGTH)
    )
    joints, share = BY_LOAD
    more = LoadDependentFriction(joints)
    names = [one.name for effect in nominal.effects for one in effect.parameters(nominal.robot)]
    stated = {name: Prior(value) for name in names for key, value in TERMS.items() if name.startswith(key)}
    stated |= {one.name: Prior(share) for one in more.parameters(nominal.robot)}
    robot = replace(
        nominal.robot, limits=limits, servo=servo, drive_gain=stiffness, drive_gain_tolerance=np.full(n, 0.1)
    )
    return as_built(Model(robot, (*nominal.effects, more), stated))


def steps(_folder: Path, _length: float, _search: float) -> list[Step]:
    """None: they are a person's."""
    return []


def outcome(folder: Path) -> str:
    """What each file is."""
    rows = [
        [str(folder / ARM), "MJCF of the arm, as its owner has it for simulations"],
        [str(folder / NOMINAL), "what is beside it for exidyn: limits, and that the drives are servos"],
        [str(folder / TRUTH), "what the simulated arm really is, to compare with"],
        [str(folder / LOADED), f"the same holding {MASS:g} kg"],
    ]
    return "\n".join(table(["file", "what it is"], rows, left=(0, 1)))
