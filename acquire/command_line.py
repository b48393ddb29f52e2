"""The command `exidyn`: one line a subcommand, each imported when it is asked for."""

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.metadata import version
from types import ModuleType

from exidyn.identify.errors import ExidynError

from .arguments.common import CommandParser
from .arguments.exit_codes import INTERRUPTED, NOBODY_READS, REFUSED, STOPPED, codes_help

COMMANDS: dict[str, str] = {
    "example": "simulate an arm, identify it, compare with the truth",
    "compare": "a simulation beside a recording: where they differ",
    "completion": "Tab completion for bash, zsh, fish and others",
    "diagnose": "which physics a model leaves out, and the proof",
    "drivers": "robot controllers, and the settings of each",
    "excite": "the trajectory that identifies an arm best within its limits",
    "export": "a model for other simulators: URDF, MJCF, JSON, robot.toml",
    "identify": "dynamics and drive gains from recordings",
    "import": "other people's files to recordings (.mcap)",
    "info": "what is inside a recording",
    "jog": "one joint a few degrees and back, and whether it does as it should",
    "record": "play a planned motion on a controller, and record it",
    "recover": "whole recordings of what a crash left",
    "report": "runs, fit, diagnosis, before and after on one page",
    "show": "a planned motion against limits: table, page, view, exports",
    "simulate": "a planned motion in closed loop on a simulated arm",
    "view": "recordings, a fit or a diagnosis in Rerun, the arm moving",
    "watch": "what a controller measures, live; nothing is commanded",
}
"""Name -> what it does in a line. Its module NAME_command.py has `parser()` and `main(arguments)`, which
returns the exit code."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `exidyn`.

    Args:
        arguments: Behind the command's name; those of the process by default.

    Returns:
        Exit code, one of `exit_codes`.
    """
    try:
        try:
            return _answered(arguments)
        finally:
            if sys.stdout is not None:  # as it is where it was closed
                sys.stdout.flush()  # here, where it still can be told why that fails
    except BrokenPipeError:
        # What is left in the buffer would be tried again at the end of the process, with a complaint.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return NOBODY_READS


def _answered(arguments: Sequence[str] | None) -> int:
    """Run a command; errors that a person can do something about become a line."""
    top = _parser()
    if not (sys.argv[1:] if arguments is None else arguments):
        top.print_help()
        return 0
    given = top.parse_args(arguments)
    try:
        return command_module(given.command).main(given.rest)
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
        if not _for_the_user(error):
            raise
        return _said(" ".join(str(error).split()), _code(error))


def _said(line: str, code: int) -> int:
    print(f"exidyn: {line}", file=sys.stderr)
    return code


def _for_the_user(error: Exception) -> bool:
    """Whether the error was raised on purpose, with a text that says what to do."""
    from exidyn.drivers.errors import DriverError  # imports numpy, which a help text can do without

    return isinstance(error, ExidynError | DriverError)


def _code(error: Exception) -> int:
    from .run.errors import NotConfirmed  # likewise

    return STOPPED if isinstance(error, NotConfirmed) else REFUSED


def _parser() -> argparse.ArgumentParser:
    width = max(map(len, COMMANDS))
    lines = [f"  {name:<{width}}  {purpose}" for name, purpose in COMMANDS.items()]
    parser = CommandParser(
        prog="exidyn",
        description="Find out what a robot arm's dynamics really are.",
        epilog="\n\n".join(
            [
                "commands:\n" + "\n".join(lines),
                codes_help(),
                "'exidyn COMMAND --help' explains a command. To begin: exidyn example",
            ]
        ),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"exidyn {version('exidyn')}")
    parser.add_argument("command", choices=COMMANDS, metavar="COMMAND", help="one of those below")
    parser.add_argument("rest", nargs=argparse.REMAINDER, metavar="...", help="its arguments")
    return parser


def command_module(name: str) -> ModuleType:
    """The module of a command, with `parser` and `main`."""
    return import_module(f"{__package__}.commands.{name}_command")


if __name__ == "__main__":
    sys.exit(main())
