"""The commands: each is a function in NAME_command.py and a line in this table, and is imported when it runs.

In: arguments of a command.
Out: files, text, an exit code.
"""

import shlex
import sys
from collections.abc import Sequence
from importlib import import_module
from shutil import get_terminal_size

from ..arguments.command import Command, WrongUse
from ..arguments.parser import DONE

GROUPS: dict[str, dict[str, str]] = {
    "get started": {
        "example": "simulate an arm, identify it, compare with the truth",
        "init": "make a robot.toml from a log and a URDF, or a controller file",
        "import": "convert logs of other tools to recordings (.mcap)",
        "info": "print the contents of a recording, or repair it after a crash",
    },
    "plan and record": {
        "excite": "plan the trajectory that identifies an arm best, or show one",
        "watch": "show what a controller measures, live; nothing is commanded",
        "jog": "move one joint a few degrees and back, and judge its settings",
        "record": "play a planned motion on a controller, and record it",
    },
    "identify and diagnose": {
        "identify": "identify dynamics and drive gains from recordings",
        "payload": "identify the payload on the flange: mass, center of mass, inertia",
        "diagnose": "find the physics that a model lacks, and the evidence",
    },
    "use a model": {
        "contact": "estimate external torques along a recording, and find contacts",
        "compensate": "write torque for gravity and friction, in Python and C++",
    },
    "simulate and export": {
        "simulate": "simulate a planned motion, and compare it with a recording",
        "gap": "compare a MuJoCo simulation with the real arm, and improve its MJCF",
        "export": "write a model for other simulators: URDF, MJCF, JSON, robot.toml",
    },
    "view results": {"view": "view recordings, a fit or a diagnosis in Rerun, the arm moving"},
}
"""Task -> its commands, and what each does in one line."""
COMMANDS = {name: line for group in GROUPS.values() for name, line in group.items()}
"""Command -> what it does in one line."""


def command(name: str) -> Command:
    """Import a command of the table."""
    imported: Command = getattr(import_module(f"{__name__}.{name}_command"), f"{name}_command")
    return imported


def run_command(name: str, arguments: Sequence[str]) -> int:
    """Parse the arguments of a command, run it, deliver its result, and return the exit code."""
    chosen = command(name)
    parser = chosen.parser()
    try:
        args = parser.parse_args(arguments)
        args.typed = shlex.join([name, *arguments])
        _fit_to_terminal()
        result = chosen.run(args)
    except WrongUse as error:
        parser.error(str(error))
    if isinstance(result, int):
        return result
    if result is not None:
        result.deliver(args)
    return DONE


def _fit_to_terminal() -> None:
    """Let pages use the width of the terminal that shows them."""
    if sys.stdout is not None and sys.stdout.isatty():
        from exidyn.identification.text_table import WIDEST, WIDTH, page_width

        page_width.set(min(max(get_terminal_size().columns, WIDTH), WIDEST))
