"""The command `exidyn`: which subcommand is asked for, and what its errors become."""

import argparse
import os
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from typing import Any

from exidyn.identification.errors import ExidynError, RobotWarning

from .arguments.command import Option, name_lines, print_warning
from .arguments.exit_codes import INTERRUPTED, MEANINGS, READER_LEFT, REFUSED, STOPPED, UNSAFE
from .arguments.parser import CommandParser, complaint
from .commands import COMMANDS, GROUPS, command
from .screen import screens


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `exidyn`.

    Args:
        arguments: Behind the command's name; those of the process by default.

    Returns:
        Exit code, one of `exit_codes`.
    """
    try:
        with screens():
            try:
                return _answered(arguments)
            finally:
                if sys.stdout is not None:  # as it is where it was closed
                    sys.stdout.flush()  # here, where the reason of a failure can still be reported
    except BrokenPipeError:
        # What is left in the buffer would be tried again at the end of the process, with a complaint.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return READER_LEFT


def _answered(arguments: Sequence[str] | None) -> int:
    """Run a command; errors that a person can do something about become a line."""
    top = _parser()
    if not (sys.argv[1:] if arguments is None else arguments):
        top.print_help()
        return 0
    given = top.parse_args(arguments)
    try:
        with _warnings_as_lines():
            return command(given.command).main(given.rest)
    except BrokenPipeError:
        raise
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        return _said(f"{place}{error.strerror or error}", REFUSED)
    except MemoryError as error:
        return _said(f"not enough memory ({error}): ask for less time, or fewer points a second", REFUSED)
    except KeyboardInterrupt:
        return _said("interrupted", INTERRUPTED)
    except Exception as error:
        # imports numpy, which a help text can do without
        from exidyn.drivers.errors import DriverError

        from .run.errors import NotConfirmed, RunStopped, Unsafe

        if not isinstance(error, ExidynError | DriverError):  # raised on purpose, these name what to do
            raise
        code = STOPPED if isinstance(error, NotConfirmed | RunStopped) else REFUSED
        code = UNSAFE if isinstance(error, Unsafe) else code
        return _said(" ".join(str(error).split()), code)


@contextmanager
def _warnings_as_lines() -> Iterator[None]:
    """Inside, a warning about a robot's description is a line on standard error, once a text."""
    with warnings.catch_warnings():
        usual = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            if issubclass(category, RobotWarning):
                print_warning(message)
            else:
                usual(message, category, *place, **more)

        warnings.showwarning = show
        yield


def _said(line: str, code: int) -> int:
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
    Option("command COMMAND", "one of those below", COMMANDS).add_to(parser)
    parser.add_argument("rest", nargs=argparse.REMAINDER, metavar="...", help="its arguments")
    return parser


if __name__ == "__main__":
    sys.exit(main())
