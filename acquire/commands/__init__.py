"""The commands: each is a function in NAME_command.py and a line in this table, and is imported when it runs.

In: arguments of a command.
Out: files, text, an exit code.
"""

from importlib import import_module

from ..arguments.command import Command

GROUPS: dict[str, dict[str, str]] = {
    "get started": {
        "example": "simulate an arm, identify it, compare with the truth",
        "init": "make a robot.toml from a log and a URDF: columns, units, gains",
        "import": "convert logs of other tools to recordings (.mcap)",
        "info": "print the contents of a recording",
        "completion": "Tab completion for bash, zsh, fish and others",
    },
    "plan and record": {
        "excite": "plan the trajectory that identifies an arm best within its limits",
        "show": "show a planned motion against limits: table, page, view, exports",
        "drivers": "list robot controllers, and the settings of each",
        "watch": "show what a controller measures, live; nothing is commanded",
        "jog": "move one joint a few degrees and back, and judge its settings",
        "record": "play a planned motion on a controller, and record it",
        "hold": "let the arm float by a fit's torque, and measure its drift",
        "recover": "rebuild a recording that a crash left incomplete",
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
        "simulate": "simulate a planned motion in closed loop",
        "compare": "compare a simulation with a recording",
        "gap": "compare a MuJoCo simulation with the real arm, and improve its MJCF",
        "export": "write a model for other simulators: URDF, MJCF, JSON, robot.toml",
    },
    "view results": {
        "report": "put runs, fit and diagnosis on one page",
        "view": "view recordings, a fit or a diagnosis in Rerun, the arm moving",
    },
}
"""Task -> its commands, and what each does in one line."""
COMMANDS = {name: line for group in GROUPS.values() for name, line in group.items()}
"""Command -> what it does in one line."""
NEIGHBORS = {"completion": "drivers", "recover": "info", "view": "report"}
"""Short command -> the command whose file contains it."""


def command(name: str) -> Command:
    """Import a command of the table."""
    module = import_module(f"{__name__}.{NEIGHBORS.get(name, name)}_command")
    imported: Command = getattr(module, f"{name}_command")
    return imported
