"""The commands, each a function in NAME_command.py and a line in this table, imported when it is asked for.

In: their arguments.
Out: files, text, an exit code.
"""

from importlib import import_module

from ..arguments.command import Command

GROUPS: dict[str, dict[str, str]] = {
    "get started": {
        "example": "simulate an arm, identify it, compare with the truth",
        "init": "a robot.toml from a log and a URDF: columns, units, gains",
        "import": "other people's files to recordings (.mcap)",
        "info": "what is inside a recording",
        "completion": "Tab completion for bash, zsh, fish and others",
    },
    "plan and record": {
        "excite": "the trajectory that identifies an arm best within its limits",
        "show": "a planned motion against limits: table, page, view, exports",
        "drivers": "robot controllers, and the settings of each",
        "watch": "what a controller measures, live; nothing is commanded",
        "jog": "one joint a few degrees and back, and whether it does as it should",
        "record": "play a planned motion on a controller, and record it",
        "recover": "whole recordings of what a crash left",
    },
    "identify and diagnose": {
        "identify": "dynamics and drive gains from recordings",
        "diagnose": "which physics a model leaves out, and the proof",
        "study": "run after run, each chosen by what is open, until the model is decided",
        "fleet": "many arms: which one changed, in what, and since when",
    },
    "simulate and export": {
        "simulate": "a planned motion in closed loop on a simulated arm",
        "compare": "a simulation beside a recording: where they differ",
        "gap": "a MuJoCo simulation beside the real arm, and a better MJCF",
        "export": "a model for other simulators: URDF, MJCF, JSON, robot.toml",
    },
    "view results": {
        "report": "runs, fit, diagnosis, before and after on one page",
        "view": "recordings, a fit or a diagnosis in Rerun, the arm moving",
    },
}
"""What a person is about -> commands for it, and what each does in a line."""
COMMANDS = {name: line for group in GROUPS.values() for name, line in group.items()}
"""Name -> what it does in a line."""
NEIGHBOURS = {"completion": "drivers", "recover": "info", "view": "report"}
"""Short command -> the one in whose file it is."""


def command(name: str) -> Command:
    """A command of the table, imported."""
    module = import_module(f"{__name__}.{NEIGHBOURS.get(name, name)}_command")
    found: Command = getattr(module, f"{name}_command")
    return found
