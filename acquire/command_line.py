"""The command `exidyn`: one line a subcommand, each imported when it is asked for."""

import argparse
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.metadata import version
from typing import NamedTuple

from exidyn.identify.errors import ExidynError


class Command(NamedTuple):
    """A subcommand: "module:function" in this package, and what it does in a line."""

    place: str
    purpose: str


COMMANDS: dict[str, Command] = {
    "example": Command("example_command:main", "simulate an arm, identify it, compare with the truth"),
    "compare": Command("compare_command:main", "a simulation beside a recording: where they differ"),
    "diagnose": Command("diagnose_command:main", "which physics a model leaves out, and the proof"),
    "drivers": Command("drivers_command:main", "robot controllers, and the settings of each"),
    "excite": Command("excite_command:main", "the trajectory that identifies an arm best within its limits"),
    "export": Command("export_command:main", "a model for other simulators: URDF, MJCF, JSON, robot.toml"),
    "identify": Command("identify_command:main", "dynamics and drive gains from recordings"),
    "import": Command("import_command:main", "other people's files to recordings (.mcap)"),
    "info": Command("info_command:main", "what is inside a recording"),
    "record": Command("record_command:main", "play a planned motion on a controller, and record it"),
    "recover": Command("recover_command:main", "whole recordings of what a crash left"),
    "show": Command("show_command:main", "a planned motion against limits: table, page, view, exports"),
    "simulate": Command("simulate_command:main", "a planned motion in closed loop on a simulated arm"),
    "view": Command("view_command:main", "recordings, a fit or a diagnosis in Rerun, the arm moving"),
}
"""Name -> where; each function takes the arguments behind its name and returns the exit code."""

REFUSED = 2
"""Exit code where something given was wrong, as argparse has it."""

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it: 128 + SIGINT."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `exidyn`.

    Args:
        arguments: Behind the command's name; those of the process by default.

    Returns:
        Exit code: 0, `REFUSED` or `INTERRUPTED`.
    """
    parser = _parser()
    if not (sys.argv[1:] if arguments is None else arguments):
        parser.print_help()
        return 0
    given = parser.parse_args(arguments)
    try:
        return _function(given.command)(given.rest)
    except OSError as error:
        print(f"exidyn: {error.filename or 'file'}: {error.strerror or error}", file=sys.stderr)
        return REFUSED
    except KeyboardInterrupt:
        print("exidyn: interrupted", file=sys.stderr)
        return INTERRUPTED
    except Exception as error:
        if not _for_the_user(error):
            raise
        print(f"exidyn: {' '.join(str(error).split())}", file=sys.stderr)
        return REFUSED


def _for_the_user(error: Exception) -> bool:
    """Whether the error was raised on purpose, with a text that says what to do."""
    from exidyn.drivers.errors import DriverError  # imports numpy, which a help text can do without

    return isinstance(error, ExidynError | DriverError)


def _parser() -> argparse.ArgumentParser:
    width = max(map(len, COMMANDS))
    lines = [f"  {name:<{width}}  {command.purpose}" for name, command in COMMANDS.items()]
    parser = argparse.ArgumentParser(
        prog="exidyn",
        description="Find out what a robot arm's dynamics really are.",
        epilog="commands:\n" + "\n".join(lines) + "\n\n'exidyn COMMAND --help' explains a command.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"exidyn {version('exidyn')}")
    parser.add_argument("command", choices=COMMANDS, metavar="COMMAND", help="one of those below")
    parser.add_argument("rest", nargs=argparse.REMAINDER, metavar="...", help="its arguments")
    return parser


def _function(name: str) -> Callable[[Sequence[str]], int]:
    module, function = COMMANDS[name].place.split(":")
    return getattr(import_module(f"{__package__}.{module}"), function)


if __name__ == "__main__":
    sys.exit(main())
