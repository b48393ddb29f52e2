"""A command of the command line: its function, its options, and its help."""

import argparse
import math
import sys
import textwrap
from argparse import ArgumentTypeError, Namespace
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from .parser import WIDTH, CommandParser, complaint, nearest

T = TypeVar("T")


@dataclass(frozen=True)
class Option:
    """An option or a positional argument of a command."""

    # Names and placeholders of the values, as typed. "--yes" takes no value, "--com X Y Z" three, "--current
    # A..." one or more, "--serve [ADDRESS]" one or none; "runs RUN..." is positional.
    form: str
    meaning: str  # help text with the unit; the default is appended
    # Function that converts the text to a value, or the valid values.
    kind: Callable[[str], Any] | Collection[str] = str
    default: Any = None  # value if the option is absent
    alone: Any = None  # value of an option with an optional value if it comes without one
    repeated: bool = False  # whether the option may be repeated, each time extending a list
    required: bool = False  # whether the command needs the option
    dest: str = ""  # name in the namespace, if it differs from the option's first name
    # argparse action that stores the values, if it is not the default one.
    action: type[argparse.Action] | None = None

    @property
    def key(self) -> str:
        """Name of its value in the namespace."""
        return self.dest or self.form.split()[0].lstrip("-").replace("-", "_")

    def add_to(self, place: argparse._ActionsContainer) -> None:
        """Add the option to a parser or to an argument group."""
        words = self.form.split()
        names = [word for word in words if word.startswith("-")] or words[:1]
        settings: dict[str, Any] = {"help": self._help()}
        if len(names) == len(words):
            settings["action"] = "store_true"
        else:
            settings |= {"default": self.default, **_arity(words[len(names) :]), **self._values()}
        if self.repeated:
            settings["action"] = "extend" if settings.get("nargs") == "+" else "append"
        extras = {"required": self.required, "dest": self.dest, "action": self.action}
        settings |= {key: value for key, value in extras.items() if value}
        if self.alone is not None:
            settings["const"] = self.alone
        place.add_argument(*names, **settings)

    def _values(self) -> dict[str, Any]:
        if callable(self.kind):
            return {"type": self.kind}
        return {"type": _choice_of(self.kind), "choices": list(self.kind)}

    def _help(self) -> str:
        needs_none = "default" in self.meaning or isinstance(self.default, bool)
        if needs_none or self.default == "" or not isinstance(self.default, str | int | float | Path):
            return self.meaning
        default = f"{self.default:g}" if isinstance(self.default, float) else self.default
        return "; ".join(filter(None, (self.meaning, f"default: {default}")))


def _arity(values: Sequence[str]) -> dict[str, Any]:
    """The `nargs` and `metavar` that argparse needs for these placeholders."""
    [first, *others] = values
    if others:
        return {"nargs": len(values), "metavar": tuple(values)}
    optional, several = first.startswith("["), "..." in first
    nargs = {(False, False): None, (False, True): "+", (True, False): "?", (True, True): "*"}
    return {"nargs": nargs[optional, several], "metavar": first.strip("[]").removesuffix("...")}


class Group(NamedTuple):
    """Options below a title in the help."""

    title: str  # title of the group; empty for mutually exclusive options, which have no title
    options: Iterable[Option]  # options in the order of the help

    def add_to(self, parser: argparse.ArgumentParser) -> None:
        """Add the options to a parser."""
        group = parser.add_argument_group(self.title) if self.title else parser.add_mutually_exclusive_group()
        for option in self.options:
            option.add_to(group)


@dataclass(frozen=True)
class Command:
    """A command; it decorates the function NAME_command, which the command NAME then runs."""

    description: str  # what the command does, in one or two sentences
    # One or more command lines as a person would type them; text after # is a comment.
    examples: Sequence[str]
    options: Sequence[Option | Group]  # options in the order of the help
    notes: str = ""  # tables between options and examples
    usage: str | None = None  # usage line, if the generated one would be too long
    # Function of the parsed arguments that returns a `Result`, the exit code, or None for "done".
    run: Callable[[Namespace], Any] = lambda args: None

    def __call__(self, run: Callable[[Namespace], Any]) -> "Command":
        """The command with a function to run."""
        return replace(self, run=run)

    def parser(self) -> "CommandParser":
        """The parser that reads the command's arguments and prints its help."""
        shown = "\n".join(["examples:", *(f"  {line}" for line in self.examples)])
        parser = CommandParser(
            prog=f"exidyn {self.run.__name__.removesuffix('_command')}",
            usage=self.usage,
            description=_wrapped(self.description),
            epilog=f"{self.notes.strip()}\n\n{shown}" if self.notes else shown,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        for option in self.options:
            option.add_to(parser)
        return parser


class WrongUse(Exception):
    """Options that exclude each other in a way that the parser cannot check."""


def refuse_with(option: str, args: Namespace, others: Iterable[Option]) -> None:
    """Raise `WrongUse` if an option that this one excludes has another value than its default."""
    for name in _stated(args, others):
        raise WrongUse(f"{option} and {name} cannot be used together")


def refuse_without(option: str, args: Namespace, others: Iterable[Option]) -> None:
    """Raise `WrongUse` if an option has another value than its default without the one that it needs."""
    for name in _stated(args, others):
        raise WrongUse(f"{name} is only used with {option}")


def _stated(args: Namespace, options: Iterable[Option]) -> list[str]:
    """Names of the options that have another value than their default."""
    values = ((option, getattr(args, option.key)) for option in options)
    return [option.form.split()[0] for option, value in values if value not in (None, False, option.default)]


def _choice_of(valid: Collection[str]) -> Callable[[str], str]:
    """A function that returns a text unchanged if it is a valid choice."""

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
    """The description, rewrapped if a line of it is too long for a terminal."""
    too_long = any(len(line) > WIDTH for line in description.splitlines())
    return textwrap.fill(" ".join(description.split()), WIDTH) if too_long else description


def name_lines(title: str, texts: Mapping[str, str]) -> str:
    """A title, and below it one line for each name with its text, the texts aligned."""
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
    """Like `name_lines`, for functions or classes: each name, and the first line of its docstring."""
    texts = {name: (documented.__doc__ or "").partition("\n")[0] for name, documented in table.items()}
    return name_lines(title, texts)


def any_number(text: str) -> float:
    """A number, infinity and NaN included; for values that are checked later, where more is known."""
    try:
        return float(text)
    except ValueError:
        raise ArgumentTypeError(f"'{text}' is not a number") from None


def integer(text: str) -> int:
    """A whole number; for values that are checked later, as with `any_number`."""
    try:
        return int(text)
    except ValueError:
        raise ArgumentTypeError(f"'{text}' is not a whole number") from None


def valid_if(test: Callable[[T], bool], refusal: str, kind: Callable[[str], T]) -> Callable[[str], T]:
    """A function that converts a text to a value, and refuses one that fails a test.

    The refusal is the rest of the error message after the text: what is wrong, and what would be valid.
    """

    def check(text: str) -> T:
        value = kind(text)
        if not test(value):
            raise ArgumentTypeError(f"{text} {refusal}")
        return value

    return check


number = valid_if(math.isfinite, "is not a finite number", any_number)
positive = valid_if(lambda value: 0.0 < value < math.inf, "must be above 0", any_number)
not_negative = valid_if(lambda value: value >= 0, "must be 0 or more", integer)
percent = valid_if(
    lambda share: 0.0 < share <= 1.0,
    "is not above 0 and at most 100 %",
    lambda text: any_number(text.rstrip("%")) / 100.0,
)
"""A share [-] from a text in percent."""
