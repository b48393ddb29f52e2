"""exidyn view: recordings, a fit or a diagnosis in Rerun."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from exidyn.identify.robot_files.robot_file import read_model

from ..arguments.common import add_robot, command_parser
from ..arguments.outputs import require_apart
from ..terminal.json_output import print_written
from ..views.live_view import LOCAL, PORT, Targets

EXAMPLES = (
    "exidyn view run.mcap other.mcap",
    "exidyn view exidyn-fit/fit.json run.mcap --save fit.rrd",
    "exidyn view exidyn-diagnosis/diagnosis.json --serve",
)


def main(arguments: Sequence[str]) -> int:
    """Show."""
    given = parser().parse_args(arguments)
    if given.save is not None:
        require_apart(given.save, "--save", given.files)
    from ..views.kinds import view_of  # Rerun takes a second to import, and a help text can do without
    from ..views.viewers import show

    model = read_model(given.robot) if given.robot else None
    window = given.save is None and given.serve is None
    show(view_of(given.files, model), Targets(window, given.serve, given.save))
    if given.save is not None:
        print_written(given.save)
    return 0


def parser() -> argparse.ArgumentParser:
    """What `exidyn view` takes."""
    found = command_parser(
        "view",
        "Show recordings, a fit and what it predicts of them, or a diagnosis, in a window of Rerun's viewer.",
        EXAMPLES,
    )
    found.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="recordings (.mcap, .csv, case folder); or fit.json and recordings; or diagnosis.json",
    )
    add_robot(found, "for tables, which do not name their robot")
    found.add_argument(
        "--save",
        "--output",
        "-o",
        type=Path,
        metavar="FILE",
        help="write a file for Rerun's viewer (.rrd) instead",
    )
    found.add_argument(
        "--serve",
        "--browser",
        nargs="?",
        const=f"{LOCAL}:{PORT}",
        metavar="ADDRESS:PORT",
        help=f"serve it to browsers instead, until Ctrl-C; default: {LOCAL}:{PORT}, this machine only",
    )
    return found
