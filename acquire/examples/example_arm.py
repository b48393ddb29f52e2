"""A simulated arm with known truth, its robot files, and commands as a person would type them."""

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.model import Model
from exidyn.identification.robot_files.commented import commented_text

MASS = 175.0
"""Mass of the payload, as in the paper [kg]."""
CENTER = (0.05, 0.03, -0.22)
"""Its center of mass [m]: a tool about twenty centimeters in front of the flange, which points along -z."""
INERTIA = (8.0, 0.1, 0.2, 9.0, 0.3, 7.0)
"""Its inertia about the center of mass, XX, XY, XZ, YY, YZ, ZZ [kg m^2]."""
BODY = known_parameters(MASS, CENTER, INERTIA)
"""True parameters of the payload; the stated ones may differ."""
NOMINAL, TRUTH, LOADED = "robot.toml", "truth.toml", "truth-loaded.toml"
"""Files of the nominal arm, the true arm, and the true arm with its payload."""
ITERATIONS, LEAST = 100, 25
"""Iterations of each start of a search, and those for motions that need not be optimal. Unlike a time, they
lead to the same motion on a slow or busy computer."""


@dataclass(frozen=True)
class ExampleArm:
    """A true arm, whose nominal values are the true ones, and its nominal model with an error or omission."""

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
    """A command of exidyn and its arguments."""

    command: str
    arguments: tuple[str, ...]

    def __str__(self) -> str:
        return f"exidyn {self.command} {shlex.join(self.arguments)}"


def step(command: str, *arguments: str | Path | float) -> Step:
    """A command with its arguments; floats are printed without trailing zeros."""
    return Step(command, tuple(f"{a:g}" if isinstance(a, float) else str(a) for a in arguments))


def excited(
    folder: Path, name: str, length: float, search: float | None, *more: str | float, least: bool = False
) -> Step:
    """Command that plans a motion of a duration [s] in folder/name.toml.

    The duration `length` and the search time are in s; without a search time, the number of iterations is
    fixed. With `least`, the motion need not be optimal, and a quarter of the search is enough.
    """
    share = LEAST / ITERATIONS if least else 1.0
    budget = (
        ("--iterations", LEAST if least else ITERATIONS) if search is None else ("--search", search * share)
    )
    options = "--length", length, *more, *budget
    return step("excite", folder / NOMINAL, *options, "--output", folder / f"{name}.toml")


def recorded(folder: Path, name: str, motion: str, seed: int, *payload: str | float) -> Step:
    """Command that records folder/motion.toml in folder/name.mcap on the mock with the true arm.

    The payload options are the stated values; without them the true arm carries no payload.
    """
    plant = folder / (LOADED if payload else TRUTH)
    mock = "--driver", "mock", "--plant", plant, "--seed", str(seed)
    robot = "--robot", folder / NOMINAL
    return step(
        "record", folder / f"{motion}.toml", *robot, *mock, *payload, "--output", folder / f"{name}.mcap"
    )
