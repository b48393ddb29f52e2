"""A simulated KR270 whose truth is known, its robot files, and what a person with a cell would type."""

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.model import Model
from exidyn.identification.robot_files.commented import commented_text

MASS = 175.0
"""Payload [kg], as in the paper."""
CENTRE = (0.05, 0.03, -0.22)
"""Its centre of mass [m]: a tool some twenty centimetres in front of the flange, which looks along -z."""
INERTIA = (8.0, 0.1, 0.2, 9.0, 0.3, 7.0)
"""Its moments about that, XX, XY, XZ, YY, YZ, ZZ [kg m^2]."""
BODY = known_parameters(MASS, CENTRE, INERTIA)
"""What the payload really is, by parameter; what is stated about it may differ."""
NOMINAL, TRUTH, LOADED = "robot.toml", "truth.toml", "truth-loaded.toml"
"""Files of the arm nominal, as it is, and as it is with its payload."""
LEAST = 5.0
"""Time in which motions are searched that need not be the best [s]."""


@dataclass(frozen=True)
class ExampleArm:
    """An arm as it is, its priors being true, and nominal, with something wrong or missing."""

    truth: Model
    nominal: Model

    def files(self) -> Mapping[str, str]:
        """Robot files, name -> text."""
        models = {NOMINAL: self.nominal, TRUTH: self.truth, LOADED: self.truth + Payload("L", BODY)}
        return {name: commented_text(model) for name, model in models.items()}

    def write(self, folder: Path) -> None:
        """Write the robot files into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in self.files().items():
            (folder / name).write_text(text, encoding="utf-8")


class Step(NamedTuple):
    """One command of exidyn by its name, and its arguments."""

    command: str
    arguments: tuple[str, ...]

    def __str__(self) -> str:
        return f"exidyn {self.command} {shlex.join(self.arguments)}"


def step(command: str, *arguments: str | Path | float) -> Step:
    """A command with its arguments, numbers in as few digits as they have."""
    return Step(command, tuple(f"{a:g}" if isinstance(a, float) else str(a) for a in arguments))


def excited(folder: Path, name: str, length: float, search: float, *more: str | float) -> Step:
    """Plan a motion of a length [s], searched for so long [s], for the nominal arm, in folder/name.toml."""
    asked = "--length", length, *more, "--search", search
    return step("excite", folder / NOMINAL, *asked, "--output", folder / f"{name}.toml")


def recorded(folder: Path, name: str, motion: str, seed: int, *payload: str | float) -> Step:
    """Record folder/motion.toml in folder/name.mcap on the mock, whose arm is the true one.

    The payload is what is stated about the body on the flange, which is there if anything is stated.
    """
    plant = folder / (LOADED if payload else TRUTH)
    mock = "--driver", "mock", "--plant", plant, "--seed", str(seed)
    robot = "--robot", folder / NOMINAL
    return step(
        "record", folder / f"{motion}.toml", *robot, *mock, *payload, "--output", folder / f"{name}.mcap"
    )
