"""What the command lines of all commands share: their parser, numbers, and options that several have."""

import argparse
import math
import sys
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

from .exit_codes import REFUSED

WIDTH = 80
"""Columns of a page: what every terminal shows."""


class CommandParser(argparse.ArgumentParser):
    """A parser whose complaint is one line: a page of usage would hide it."""

    def error(self, message: str) -> NoReturn:
        """Print what is wrong, and end."""
        line = f"{self.prog}: {' '.join(message.split())}. '{self.prog} --help' explains"
        self.exit(REFUSED, f"{complaint(line)}\n")


def complaint(line: str) -> str:
    """A line for standard error: one for scripts, wrapped between words for a person."""
    if sys.stderr is None or not sys.stderr.isatty():
        return line
    return textwrap.fill(line, WIDTH, break_long_words=False, break_on_hyphens=False)


def command_parser(
    name: str, description: str, examples: Sequence[str], notes: str = "", usage: str | None = None
) -> CommandParser:
    """The parser of a subcommand.

    Args:
        name: Of the command.
        description: What it does, in a sentence or two.
        examples: One to a few command lines as a person would type them; what follows # is a comment.
        notes: Tables that belong between options and examples.
        usage: In place of the one from the options, where that would be long.
    """
    shown = "\n".join(["examples:", *(f"  {line}" for line in examples)])
    return CommandParser(
        prog=f"exidyn {name}",
        usage=usage,
        description=_wrapped(description),
        epilog=f"{notes.strip()}\n\n{shown}" if notes else shown,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def _wrapped(description: str) -> str:
    """The same, lines that are too long for a terminal together with those behind them wrapped anew."""
    too_long = any(len(line) > WIDTH for line in description.splitlines())
    return textwrap.fill(" ".join(description.split()), WIDTH) if too_long else description


def name_lines(title: str, texts: Mapping[str, str]) -> str:
    """A title, and name and text of each on lines of their own, texts below one another."""
    indent = max(map(len, texts)) + 4
    rows = [
        textwrap.fill(
            text,
            WIDTH,
            initial_indent=f"  {name:<{indent - 2}}",
            subsequent_indent=" " * indent,
            break_on_hyphens=False,
        )
        for name, text in texts.items()
    ]
    return "\n".join([f"{title}:", *rows])


def table_help(title: str, table: Mapping[str, Any]) -> str:
    """The same of functions or classes: each name, and the first line of its docstring."""
    return name_lines(title, {n: (one.__doc__ or "").partition("\n")[0] for n, one in table.items()})


def add_robot(parser: argparse.ArgumentParser, why: str = "", required: bool = False) -> None:
    """Add --robot."""
    # imports numpy, which the command's name can do without
    from exidyn.identify.robot_files.robot_file import builtin_names

    parser.add_argument(
        "--robot",
        required=required,
        metavar="ROBOT",
        help=f"{why}{': ' if why else ''}robot.toml, .urdf, .xacro, or built in: "
        f"{', '.join(builtin_names())}",
    )


def add_plan(parser: argparse.ArgumentParser) -> None:
    """Add TRAJECTORY."""
    meaning = "trajectory file (.toml) of exidyn excite"
    parser.add_argument("plan", type=Path, metavar="TRAJECTORY", help=meaning)


def add_body(group: argparse._ArgumentGroup) -> None:
    """Add --mass, --com and --inertia of the one body on the flange."""
    group.add_argument("--mass", type=positive, metavar="KG", help="mass of the body on it")
    group.add_argument(
        "--com", type=any_number, nargs=3, metavar=("X", "Y", "Z"), help="its centre of mass [m]"
    )
    names = ("XX", "XY", "XZ", "YY", "YZ", "ZZ")
    group.add_argument("--inertia", type=any_number, nargs=6, metavar=names, help="and about that [kg m^2]")


def add_seed(group: argparse._ActionsContainer, meaning: str) -> None:
    """Add --seed."""
    group.add_argument("--seed", type=whole, default=0, metavar="N", help=f"{meaning}; default: %(default)s")


def number(text: str) -> float:
    """A finite number."""
    value = any_number(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text} is not a finite number")
    return value


def positive(text: str) -> float:
    """A number above zero."""
    value = any_number(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text} must be above 0")
    return value


def percent(text: str) -> float:
    """A share from per cent."""
    value = any_number(text.rstrip("%")) / 100.0
    if not 0.0 < value <= 1.0:
        raise argparse.ArgumentTypeError(f"{text} is not above 0 and up to 100 per cent")
    return value


def whole(text: str) -> int:
    """A whole number from zero."""
    if integer(text) < 0:
        raise argparse.ArgumentTypeError(f"{text} must be 0 or more")
    return int(text)


def integer(text: str) -> int:
    """A whole number; for values that are looked at later, where more is known of them."""
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number") from None


def any_number(text: str) -> float:
    """A number, infinity and NaN included; for values that are looked at later, as `integer`."""
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number") from None
