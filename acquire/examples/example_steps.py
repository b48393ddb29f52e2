"""Steps of an example: command lines that a person with a cell would type, here with a simulated arm."""

import shlex
from pathlib import Path
from typing import NamedTuple

from .example_arm import LOADED, NOMINAL, TRUTH

LEAST = 5.0
"""Time in which motions are searched that need not be the best [s]."""


class Step(NamedTuple):
    """One command of exidyn.

    Attributes:
        command: Its name.
        arguments: Behind that.
    """

    command: str
    arguments: tuple[str, ...]

    def __str__(self) -> str:
        return f"exidyn {self.command} {shlex.join(self.arguments)}"


def step(command: str, *arguments: str | Path | float) -> Step:
    """A command with its arguments, numbers in as few digits as they have."""
    return Step(command, tuple(f"{a:g}" if isinstance(a, float) else str(a) for a in arguments))


def excited(folder: Path, name: str, length: float, search: float, *more: str | float) -> Step:
    """Plan a motion for the nominal arm.

    Args:
        folder: Of all files.
        name: Of the motion's file.
        length: Of the motion [s].
        search: How long it is searched [s].
        more: Further arguments.
    """
    asked = "--length", length, *more, "--search", search
    return step("excite", folder / NOMINAL, *asked, "--output", folder / f"{name}.toml")


def recorded(folder: Path, name: str, motion: str, seed: int, *payload: str | float) -> Step:
    """Record a planned motion on the mock, whose arm is the true one.

    Args:
        folder: Of all files.
        name: Of the recording's file.
        motion: Name of the motion's file.
        seed: Of the noise.
        payload: What is stated about the body on the flange, which is there if anything is stated.
    """
    plant = folder / (LOADED if payload else TRUTH)
    mock = "--driver", "mock", "--plant", plant, "--seed", str(seed)
    robot = "--robot", folder / NOMINAL
    return step(
        "record", folder / f"{motion}.toml", *robot, *mock, *payload, "--output", folder / f"{name}.mcap"
    )
