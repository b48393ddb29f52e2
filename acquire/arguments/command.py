"""What a command of the command line is: a function, the options it takes, and its help."""

import argparse
import math
import sys
import textwrap
from argparse import ArgumentTypeError, Namespace
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from .exit_codes import DONE
from .parser import WIDTH, CommandParser, complaint, nearest

T = TypeVar("T")


@dataclass(frozen=True)
class Option:
    """An option of a command, or an argument that has no option's name.

    Attributes:
        form: How it is typed: its names, then what stands for its values. "--exact" has none, "--com X Y Z"
            three, "--current A..." one or more, "--serve [ADDRESS]" one or none; "runs RUN..." an argument.
        meaning: Help, with the unit; the default is added.
        kind: What makes a value of a text, or the valid values.
        default: Without the option.
        alone: What an option of one or no value stands for without one.
        repeated: Whether it may be given several times, each adding to a list.
        required: Whether the command needs it.
        dest: Its name in the namespace, where that differs from the first of its own.
        action: What takes its values in, where that is not the usual.
    """

    form: str
    meaning: str
    kind: Callable[[str], Any] | Collection[str] = str
    default: Any = None
    alone: Any = None
    repeated: bool = False
    required: bool = False
    dest: str = ""
    action: type[argparse.Action] | None = None

    def add_to(self, place: argparse._ActionsContainer) -> None:
        """Add it to a parser or to a group of one."""
        words = self.form.split()
        names = [word for word in words if word.startswith("-")] or words[:1]
        settings: dict[str, Any] = {"help": self._help()}
        if len(names) == len(words):
            settings["action"] = "store_true"
        else:
            settings |= {"default": self.default, **_counted(words[len(names) :]), **self._values()}
        if self.repeated:
            settings["action"] = "extend" if settings.get("nargs") == "+" else "append"
        given = {"required": self.required, "dest": self.dest, "action": self.action, "const": self.alone}
        place.add_argument(*names, **settings, **{key: value for key, value in given.items() if value})

    def _values(self) -> dict[str, Any]:
        if callable(self.kind):
            return {"type": self.kind}
        return {"type": _one_of(self.kind), "choices": list(self.kind)}

    def _help(self) -> str:
        stated = "default" in self.meaning or isinstance(self.default, bool)
        if stated or self.default == "" or not isinstance(self.default, str | int | float | Path):
            return self.meaning
        default = f"{self.default:g}" if isinstance(self.default, float) else self.default
        return "; ".join(filter(None, (self.meaning, f"default: {default}")))


def _counted(values: Sequence[str]) -> dict[str, Any]:
    """How many values those are, as argparse has it, and what they are called."""
    [first, *others] = values
    if others:
        return {"nargs": len(values), "metavar": tuple(values)}
    optional, several = first.startswith("["), "..." in first
    nargs = {(False, False): None, (False, True): "+", (True, False): "?", (True, True): "*"}
    return {"nargs": nargs[optional, several], "metavar": first.strip("[]").removesuffix("...")}


class Group(NamedTuple):
    """Options below a title of their own in the help.

    Attributes:
        title: Empty for options of which only one may be given; they have no title.
        options: In the order of the help.
    """

    title: str
    options: Iterable[Option]

    def add_to(self, parser: argparse.ArgumentParser) -> None:
        """Add them to a parser."""
        group = parser.add_argument_group(self.title) if self.title else parser.add_mutually_exclusive_group()
        for option in self.options:
            option.add_to(group)


@dataclass(frozen=True)
class Command:
    """A command; as the decorator of a function NAME_command it makes that what the command NAME runs.

    Attributes:
        description: What it does, in a sentence or two.
        examples: One to a few command lines as a person would type them; what follows # is a comment.
        options: In the order of the help.
        notes: Tables that belong between options and examples.
        usage: In place of the one from the options, where that would be long.
        run: Takes the arguments as attributes, and returns the exit code, or None for "done".
    """

    description: str
    examples: Sequence[str]
    options: Sequence[Option | Group]
    notes: str = ""
    usage: str | None = None
    run: Callable[[Namespace], int | None] = lambda given: None

    def __call__(self, run: Callable[[Namespace], int | None]) -> "Command":
        """The command that runs this."""
        return replace(self, run=run)

    def main(self, arguments: Sequence[str]) -> int:
        """Run it on words of a command line; the exit code."""
        parser = self.parser()
        try:
            return self.run(parser.parse_args(arguments)) or DONE
        except WrongUse as error:
            parser.error(str(error))

    def parser(self) -> "CommandParser":
        """What reads its arguments and prints its help."""
        shown = "\n".join(["examples:", *(f"  {line}" for line in self.examples)])
        parser = CommandParser(
            prog=f"exidyn {self.run.__name__.removesuffix('_command')}",
            usage=self.usage,
            description=_wrapped(self.description),
            epilog=f"{self.notes.strip()}\n\n{shown}" if self.notes else shown,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        for one in self.options:
            one.add_to(parser)
        return parser


class WrongUse(Exception):
    """Options that do not go together, which the options themselves do not show."""


def _one_of(valid: Collection[str]) -> Callable[[str], str]:
    """The text itself, if it is valid."""

    def check(text: str) -> str:
        if text not in valid:
            names = ", ".join(map(repr, valid))
            raise ArgumentTypeError(f"invalid choice: {text!r} (choose from {names}){nearest(text, valid)}")
        return text

    return check


def print_warning(sentence: object) -> None:
    """Print a warning on standard error."""
    print(complaint(f"exidyn: warning: {sentence}"), file=sys.stderr)


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


def any_number(text: str) -> float:
    """A number, infinity and NaN included; for values that are judged later, where more is known."""
    try:
        return float(text)
    except ValueError:
        raise ArgumentTypeError(f"'{text}' is not a number") from None


def integer(text: str) -> int:
    """A whole number; for values that are looked at later, as `any_number`."""
    try:
        return int(text)
    except ValueError:
        raise ArgumentTypeError(f"'{text}' is not a whole number") from None


def valid_if(test: Callable[[T], bool], refusal: str, kind: Callable[[str], T]) -> Callable[[str], T]:
    """What makes a value of a text, and refuses one that fails a test.

    Args:
        test: Whether a value is valid.
        refusal: Behind the text, what is wrong with it and what would be right.
        kind: Makes the value.
    """

    def check(text: str) -> T:
        value = kind(text)
        if not test(value):
            raise ArgumentTypeError(f"{text} {refusal}")
        return value

    return check


number = valid_if(math.isfinite, "is not a finite number", any_number)
positive = valid_if(lambda value: 0.0 < value < math.inf, "must be above 0", any_number)
whole = valid_if(lambda value: value >= 0, "must be 0 or more", integer)
percent = valid_if(
    lambda share: 0.0 < share <= 1.0,
    "is not above 0 and up to 100 per cent",
    lambda text: any_number(text.rstrip("%")) / 100.0,
)
"""A share from per cent."""
