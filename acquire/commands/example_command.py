"""exidyn example: a simulated arm whose truth is known, through all commands, and what came of it."""

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from exidyn.identify.errors import ExidynError

from ..arguments.common import any_number, command_parser, name_lines
from ..arguments.outputs import add_output
from ..examples import example_balancer, example_files, example_gains
from ..examples.example_arm import ExampleArm
from ..examples.example_steps import Step
from . import command_module

EXAMPLES = (
    "exidyn example",
    "exidyn example balancer",
    "exidyn example balancer --commands                     # prints them, to be run one by one",
    "exidyn example files --output .                        # robot.toml and log.csv, to try commands with",
)

SHORTEST = 20.0
"""Duration [s] of the motion below which ramps and filters leave too little of it."""


class Example(NamedTuple):
    """One of them.

    Attributes:
        purpose: In a line.
        folder: Where its files go by default.
        length: Of each motion by default [s].
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
}
"""Name -> example; the first is the one by default."""


def main(arguments: Sequence[str]) -> int:
    """Run the commands that a person with a cell would, on the mock; print what came of it."""
    given = parser().parse_args(arguments)
    example = NAMED[given.example]
    folder = given.output or example.folder
    if not given.commands:
        _require_empty(folder, example.kept)
    example.arm().write(folder)
    steps = example.steps(folder, given.length or example.length, given.search or example.search)
    if given.commands:
        print("\n".join(map(str, steps)))
        return 0
    run(steps)
    print(f"\n{example.outcome(folder)}")
    return 0


def run(steps: Sequence[Step]) -> None:
    """Run commands one after another, each printed before.

    Raises:
        ExidynError: One of them ended otherwise than well.
    """
    for one in steps:
        print(f"\n$ {one}", file=sys.stderr)
        if command_module(one.command).main(one.arguments):
            raise ExidynError(f"exidyn {one.command} has stopped; its output is above")


def _require_empty(folder: Path, kept: Sequence[str]) -> None:
    taken = sorted(path for pattern in kept for path in folder.glob(pattern))
    if taken:
        raise ExidynError(f"{taken[0]} exists, and is not written over. Choose another folder (--output)")


def parser() -> argparse.ArgumentParser:
    """What `exidyn example` takes."""
    found = command_parser(
        "example",
        "Run exidyn's commands on a simulated arm whose truth is known, and compare with that.",
        EXAMPLES,
        name_lines("the examples", {name: one.purpose for name, one in NAMED.items()}),
    )
    found.add_argument(
        "example",
        nargs="?",
        choices=NAMED,
        default=next(iter(NAMED)),
        metavar="EXAMPLE",
        help=f"{', '.join(NAMED)}, see below; default: %(default)s",
    )
    add_output(found, "FOLDER", meaning=f"default: {_each('folder')}")
    found.add_argument(
        "--length", "--seconds", type=_length, metavar="S", help=f"of each run; default: {_each('length')}"
    )
    found.add_argument(
        "--search",
        type=_search,
        metavar="S",
        help=f"how long the motion is searched; default: {_each('search')}",
    )
    found.add_argument(
        "--commands",
        action="store_true",
        help="only write the robot files, and print the commands that would be run",
    )
    return found


def _each(field: str) -> str:
    """What the examples have there, in their order."""
    values = [getattr(one, field) for one in NAMED.values()]
    return ", ".join(f"{value:g}" if isinstance(value, float) else str(value) for value in values)


def _length(text: str) -> float:
    value = any_number(text)
    if not SHORTEST <= value < math.inf:
        raise argparse.ArgumentTypeError(f"{text} is too short; at least {SHORTEST:g} s")
    return value


def _search(text: str) -> float:
    value = any_number(text)
    if not value > 0:
        raise argparse.ArgumentTypeError(f"{text} is no time to search in; give more than 0 s")
    return value
