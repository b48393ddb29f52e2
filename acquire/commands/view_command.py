"""exidyn view: recordings, a fit with its predictions, or a diagnosis in Rerun's viewer."""

from argparse import Namespace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments.command import Command, Option
from ..arguments.options import require_apart, robot_option
from ..views.live_view import SAVE, SERVE
from .result import Result

if TYPE_CHECKING:
    from ..views.viewers import View


@Command(
    "Show recordings, a fit with its predictions, or a diagnosis in Rerun's viewer.",
    (
        "exidyn view run.mcap other.mcap",
        "exidyn view exidyn-fit/fit.json run.mcap --save fit.rrd",
        "exidyn view exidyn-diagnosis/diagnosis.json --serve",
    ),
    (
        Option(
            "files FILE...", "recordings (.mcap, .csv); or fit.json and recordings; or diagnosis.json", Path
        ),
        robot_option("for tables, which do not contain their robot"),
        SERVE,
        SAVE,
    ),
)
def view_command(args: Namespace) -> Result:
    """Show the view in a window, or save or serve it."""
    if args.save is not None:
        require_apart(args.save, "--save", args.files)
    args.view = args.save is None and args.serve is None
    return Result(view=partial(_view, args.files, read_model(args.robot) if args.robot else None))


def _view(files: list[Path], model: Model | None) -> "View":
    from ..views.kinds import view_of

    return view_of(files, model)
