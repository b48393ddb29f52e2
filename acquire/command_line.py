"""The command `exidyn`: runs a subcommand, turns errors into a line and a code; completion in shells."""

import argparse
import os
import sys
import warnings
from argparse import Action, ArgumentParser
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from typing import Any

from exidyn.identification.errors import ExidynError, RobotWarning

from .arguments.command import Option, name_lines, print_warning
from .arguments.parser import INTERRUPTED, MEANINGS, READER_LEFT, REFUSED, STOPPED, CommandParser, complaint
from .commands import COMMANDS, GROUPS, command, run_command
from .screen import screens

SHELLS = ("bash", "zsh", "fish", "powershell", "tcsh")
FILES = {"ARM", "FILE", "FIT", "ROBOT", "RUN", "SOURCE", "TRAJECTORY"}
"""Placeholders of values that can be files; FOLDER stands for a folder."""


class PrintScript(Action):
    """Prints the script of a shell, and ends."""

    def __call__(
        self, parser: ArgumentParser, namespace: Any, values: Any, option_string: Any = None
    ) -> None:
        """Print it; importing the parsers of all commands takes a second or two."""
        import shtab

        print(shtab.complete(parser_of_all(), values))
        parser.exit()


COMPLETION = Option(
    "--completion SHELL",
    f"print the script of Tab completion for {', '.join(SHELLS)}",
    SHELLS,
    action=PrintScript,
)


def parser_of_all() -> ArgumentParser:
    """One parser with all commands and options; `exidyn` itself imports only one command."""
    top = ArgumentParser(prog="exidyn")
    top.add_argument("--version", action="store_true", help="print the version")
    COMPLETION.add_to(top)
    commands = top.add_subparsers(dest="command", metavar="COMMAND")
    for name, purpose in COMMANDS.items():
        parser = command(name).parser()
        for action in parser._actions:
            _complete(action)
        commands.add_parser(name, parents=[parser], help=purpose, description=purpose, add_help=False)
    return top


def _complete(action: Any) -> None:
    """Tell shtab the values of an option."""
    import shtab

    from exidyn.drivers import known_drivers

    if action.metavar == "DRIVER":
        action.choices = tuple(known_drivers())
    elif action.metavar == "FOLDER":
        action.complete = shtab.DIRECTORY
    elif action.metavar in FILES and action.choices is None:
        action.complete = shtab.FILE


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `exidyn` with arguments, by default those of the process; return an exit code, see `MEANINGS`."""
    try:
        with screens():
            try:
                return _run_command(arguments)
            finally:
                if sys.stdout is not None:  # it is None if it was closed before the start
                    sys.stdout.flush()  # here, where the reason of a failure can still be reported
    except BrokenPipeError:
        # At exit, Python would flush the buffer once more and print an error.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return READER_LEFT


def _run_command(arguments: Sequence[str] | None) -> int:
    """Run a command; errors that the user can act on become one line."""
    top = _parser()
    if not (sys.argv[1:] if arguments is None else arguments):
        top.print_help()
        return 0
    parsed = top.parse_args(arguments)
    try:
        with _warnings_as_lines():
            return run_command(parsed.command, parsed.rest)
    except BrokenPipeError:
        raise
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        return _report(f"{place}{error.strerror or error}", REFUSED)
    except MemoryError as error:
        return _report(f"not enough memory ({error}): ask for less time, or fewer points a second", REFUSED)
    except KeyboardInterrupt:
        return _report("interrupted", INTERRUPTED)
    except Exception as error:
        # imports numpy, which help texts do not need
        from exidyn.drivers.errors import DriverError

        from .run.errors import NotConfirmed

        if not isinstance(error, ExidynError | DriverError):  # only these say what to do
            raise
        code = STOPPED if isinstance(error, NotConfirmed) else REFUSED
        return _report(" ".join(str(error).split()), code)


@contextmanager
def _warnings_as_lines() -> Iterator[None]:
    """Print warnings about a robot's description as lines on standard error, each text once."""
    with warnings.catch_warnings():
        default_show = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            if issubclass(category, RobotWarning):
                print_warning(message)
            else:
                default_show(message, category, *place, **more)

        warnings.showwarning = show
        yield


def _report(line: str, code: int) -> int:
    print(complaint(f"exidyn: {line}"), file=sys.stderr)
    return code


def _parser() -> argparse.ArgumentParser:
    parser = CommandParser(
        prog="exidyn",
        description="Find out what a robot arm's dynamics really are.",
        epilog="\n\n".join(
            [
                *(name_lines(title, group) for title, group in GROUPS.items()),
                name_lines("exit codes", {str(code): words for code, words in MEANINGS.items()}),
                "'exidyn COMMAND --help' explains a command. To begin: exidyn example",
            ]
        ),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"exidyn {version('exidyn')}")
    COMPLETION.add_to(parser)
    Option("command COMMAND", "one of the commands below", COMMANDS).add_to(parser)
    parser.add_argument("rest", nargs=argparse.REMAINDER, metavar="...", help="its arguments")
    return parser


if __name__ == "__main__":
    sys.exit(main())
