"""The commands, each a function in NAME_command.py and a line in this table, imported when it is asked for.

In: their arguments.
Out: files, text, an exit code.
"""

from importlib import import_module

from ..arguments.command import Command

COMMANDS: dict[str, str] = {
    "example": "simulate an arm, identify it, compare with the truth",
    "compare": "a simulation beside a recording: where they differ",
    "completion": "Tab completion for bash, zsh, fish and others",
    "diagnose": "which physics a model leaves out, and the proof",
    "drivers": "robot controllers, and the settings of each",
    "excite": "the trajectory that identifies an arm best within its limits",
    "export": "a model for other simulators: URDF, MJCF, JSON, robot.toml",
    "fleet": "many arms: which one changed, in what, and since when",
    "gap": "a MuJoCo simulation beside the real arm: what each finding closes, a better MJCF",
    "identify": "dynamics and drive gains from recordings",
    "import": "other people's files to recordings (.mcap)",
    "info": "what is inside a recording",
    "init": "what a log holds: columns, units, gains; a robot.toml to begin with",
    "jog": "one joint a few degrees and back, and whether it does as it should",
    "record": "play a planned motion on a controller, and record it",
    "recover": "whole recordings of what a crash left",
    "report": "runs, fit, diagnosis, before and after on one page",
    "show": "a planned motion against limits: table, page, view, exports",
    "simulate": "a planned motion in closed loop on a simulated arm",
    "study": "run after run, each chosen by what is open, until the model is decided",
    "view": "recordings, a fit or a diagnosis in Rerun, the arm moving",
    "watch": "what a controller measures, live; nothing is commanded",
}
"""Name -> what it does in a line."""
NEIGHBOURS = {"completion": "drivers", "recover": "info", "view": "report"}
"""Short command -> the one in whose file it is."""


def command(name: str) -> Command:
    """A command of the table, imported."""
    module = import_module(f"{__name__}.{NEIGHBOURS.get(name, name)}_command")
    found: Command = getattr(module, f"{name}_command")
    return found
