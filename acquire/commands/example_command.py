"""exidyn example: run the commands on a simulated or a recorded arm, beside what is known of it."""

import math
import sys
from argparse import Namespace
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from exidyn.identification.errors import ExidynError

from ..arguments.command import Command, Option, any_number, name_lines, valid_if
from ..arguments.options import output_option
from ..examples import example_files, example_runs
from ..examples.example_runs import ExampleArm, RecordedArm, Step
from . import run_command

SHORTEST = 20.0
"""Shortest motion [s]: ramps and filters leave too little of a shorter one."""


class Example(NamedTuple):
    """An example."""

    purpose: str  # description in one line
    folder: Path  # default folder
    length: float  # default duration of each motion [s]
    arm: Callable[[], ExampleArm | RecordedArm]  # function that returns the arm, which writes its files
    outcome: Callable[[Path], str]  # function that returns the result as text, from the files in a folder
    # Function that returns the commands for a folder, a duration [s] and a search time [s]; None for a fixed
    # number of iterations. Without commands the user runs some.
    steps: Callable[[Path, float, float | None], list[Step]] = lambda folder, length, search: []
    protected: Iterable[str] = ("*.mcap*",)  # patterns of files that the example does not overwrite


NAMED = {
    "gains": Example(
        "nominal drive gains that are 10 % too large: excite, record, identify",
        Path("exidyn-example"),
        54.0,
        example_runs.gains_arm,
        example_runs.gains_outcome,
        example_runs.gains_steps,
    ),
    "real": Example(
        "recordings of a KUKA KR300 whose description lacks the counterbalance of joint 2: diagnose",
        Path("exidyn-example-real"),
        20.0,
        RecordedArm,
        example_runs.real_outcome,
        example_runs.real_steps,
        example_runs.FILES,
    ),
    "files": Example(
        "robot.toml and log.csv of a simulated arm, to try commands on; runs nothing",
        Path("exidyn-example-files"),
        20.0,
        example_files.arm_with_log,
        partial(example_files.file_table, example_files.WITH_LOG),
        protected=example_files.WITH_LOG,
    ),
    "servos": Example(
        "arm.xml (MJCF) and robot.toml of an arm of servos without current; runs nothing",
        Path("exidyn-example-servos"),
        20.0,
        example_files.servo_arm,
        partial(example_files.file_table, example_files.OF_SERVOS),
        protected=example_files.OF_SERVOS,
    ),
}
"""Name -> example; the first is the default."""


def _each(field: str) -> str:
    """Values of a field of all examples, separated by commas."""
    values = [getattr(example, field) for example in NAMED.values()]
    return ", ".join(f"{value:g}" if isinstance(value, float) else str(value) for value in values)


@Command(
    "Run exidyn's commands on a simulated or a recorded arm, and show what is known of it.",
    (
        "exidyn example",
        "exidyn example real",
        "exidyn example gains --commands                      # print the commands, to run them one by one",
        "exidyn example files --output .                      # robot.toml and log.csv, to try commands on",
    ),
    (
        Option("example [EXAMPLE]", f"{', '.join(NAMED)}, see below", NAMED, next(iter(NAMED))),
        output_option("FOLDER", meaning=f"default: {_each('folder')}"),
        Option(
            "--length S",
            f"duration of each run; default: {_each('length')}",
            valid_if(
                lambda length: SHORTEST <= length < math.inf,
                f"is too short; at least {SHORTEST:g} s",
                any_number,
            ),
        ),
        Option(
            "--search S",
            "search time of the first motion; default: a fixed number of iterations",
            valid_if(lambda time: time > 0, "is not a search time; give more than 0 s", any_number),
        ),
        Option("--commands", "only write the robot files, and print the commands instead of running them"),
    ),
    name_lines("the examples", {name: example.purpose for name, example in NAMED.items()}),
)
def example_command(args: Namespace) -> None:
    """Run the commands of an example on the mock, and print the result."""
    example = NAMED[args.example]
    folder = args.output or example.folder
    if not args.commands:
        existing = sorted(path for pattern in example.protected for path in folder.glob(pattern))
        if existing:
            raise ExidynError(
                f"{existing[0]} exists and is not overwritten. Choose another folder (--output)"
            )
    example.arm().write(folder)
    steps = example.steps(folder, args.length or example.length, args.search)
    if args.commands:
        print("\n".join(map(str, steps)))
        return
    run(steps)
    print(f"\n{example.outcome(folder)}")


def run(steps: Sequence[Step]) -> None:
    """Print and run commands one after another.

    Raises:
        ExidynError: If a command fails.
    """
    for step in steps:
        print(f"\n$ {step}", file=sys.stderr)
        if run_command(step.command, step.arguments):
            raise ExidynError(f"exidyn {step.command} failed; its output is above")
