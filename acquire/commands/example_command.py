"""exidyn example: a simulated arm whose truth is known, through all commands, and what came of it."""

import math
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from exidyn.identification.errors import ExidynError

from ..arguments.command import Command, Option, any_number, name_lines, valid_if
from ..arguments.options import output_option
from ..examples import example_balancer, example_files, example_gains, example_servos
from ..examples.example_arm import ExampleArm, Step
from . import command

SHORTEST = 20.0
"""Duration [s] of the motion below which ramps and filters leave too little of it."""


class Example(NamedTuple):
    """One of them.

    Attributes:
        purpose: In a line.
        folder: Where its files go by default.
        length: Length of each motion by default [s].
        search: How long the first motion is searched by default [s]; a minute finds a better one.
        arm: Makes the arm, true and nominal.
        steps: Its commands for a folder, a length of each motion [s] and a time to search it [s].
        outcome: What came of it, by the files of its folder.
        kept: Files that it does not write over; as patterns.
    """

    purpose: str
    folder: Path
    length: float
    search: float
    arm: Callable[[], ExampleArm]
    steps: Callable[[Path, float, float], list[Step]]
    outcome: Callable[[Path], str]
    kept: tuple[str, ...] = ("*.mcap*",)


NAMED = {
    "gains": Example(
        "nominal drive gains that are 10 % too large: excite, record, identify",
        Path("exidyn-example"),
        40.0,
        20.0,
        example_gains.arm,
        example_gains.steps,
        example_gains.outcome,
    ),
    "balancer": Example(
        "a spring balancer that the model lacks: excite, record, identify, diagnose, simulate, export",
        Path("exidyn-example-balancer"),
        30.0,
        10.0,
        example_balancer.arm,
        example_balancer.steps,
        example_balancer.outcome,
    ),
    "files": Example(
        "robot.toml and log.csv of a simulated arm, for commands of your own; nothing is run",
        Path("exidyn-example-files"),
        20.0,
        5.0,
        example_files.arm,
        example_files.steps,
        example_files.outcome,
        example_files.FILES,
    ),
    "servos": Example(
        "arm.xml, an MJCF, and robot.toml of an arm of servos without current; nothing is run",
        Path("exidyn-example-servos"),
        20.0,
        5.0,
        example_servos.arm,
        example_servos.steps,
        example_servos.outcome,
        example_servos.FILES,
    ),
}
"""Name -> example; the first is the one by default."""


def _each(field: str) -> str:
    """What the examples have there, in their order."""
    values = [getattr(one, field) for one in NAMED.values()]
    return ", ".join(f"{value:g}" if isinstance(value, float) else str(value) for value in values)


@Command(
    "Run exidyn's commands on a simulated arm whose truth is known, and compare with that.",
    (
        "exidyn example",
        "exidyn example balancer",
        "exidyn example balancer --commands                   # prints them, to be run one by one",
        "exidyn example files --output .                      # robot.toml and log.csv, to try commands with",
    ),
    (
        Option("example [EXAMPLE]", f"{', '.join(NAMED)}, see below", NAMED, next(iter(NAMED))),
        output_option("FOLDER", meaning=f"default: {_each('folder')}"),
        Option(
            "--length --seconds S",
            f"of each run; default: {_each('length')}",
            valid_if(
                lambda length: SHORTEST <= length < math.inf,
                f"is too short; at least {SHORTEST:g} s",
                any_number,
            ),
        ),
        Option(
            "--search S",
            f"how long the motion is searched; default: {_each('search')}",
            valid_if(lambda time: time > 0, "is no time to search in; give more than 0 s", any_number),
        ),
        Option("--commands", "only write the robot files, and print the commands that would be run"),
    ),
    name_lines("the examples", {name: one.purpose for name, one in NAMED.items()}),
)
def example_command(given: Namespace) -> None:
    """Run the commands that a person with a cell would, on the mock; print what came of it."""
    example = NAMED[given.example]
    folder = given.output or example.folder
    if not given.commands:
        _require_empty(folder, example.kept)
    example.arm().write(folder)
    steps = example.steps(folder, given.length or example.length, given.search or example.search)
    if given.commands:
        print("\n".join(map(str, steps)))
        return
    run(steps)
    print(f"\n{example.outcome(folder)}")


def run(steps: Sequence[Step]) -> None:
    """Run commands one after another, each printed before.

    Raises:
        ExidynError: One of them ended otherwise than well.
    """
    for one in steps:
        print(f"\n$ {one}", file=sys.stderr)
        if command(one.command).main(one.arguments):
            raise ExidynError(f"exidyn {one.command} has stopped; its output is above")


def _require_empty(folder: Path, kept: Sequence[str]) -> None:
    taken = sorted(path for pattern in kept for path in folder.glob(pattern))
    if taken:
        raise ExidynError(f"{taken[0]} exists, and is not written over. Choose another folder (--output)")
