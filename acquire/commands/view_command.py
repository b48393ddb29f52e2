"""exidyn view: recordings, a fit with its predictions, or a diagnosis in Rerun's viewer."""

from argparse import Namespace
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from exidyn.identification.errors import NotAFile
from exidyn.identification.fit.fit_file import read_fit, read_json
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.predicted import predicted

from ..arguments.command import Command, Option
from ..arguments.options import require_apart, robot_option
from ..files.given_runs import read_runs, renamed
from ..files.result_files import read_shown
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
    return Result(view=partial(view_of, args.files, read_model(args.robot) if args.robot else None))


def view_of(paths: Sequence[Path], model: Model | None = None) -> "View":
    """The view of recordings, of a fit and recordings that it predicts, or of a diagnosis.

    Raises:
        NotAFile: If a file cannot be shown, or not together with the others.
        RecordingError: If a recording cannot be read or is too short for the filters of the fit.
        DifferentRobot: If a recording has other joints than the fit.
    """
    # Rerun takes a second to import.
    from ..views.diagnosis_view import diagnosis_view
    from ..views.fit_view import fit_view
    from ..views.recording_view import recording_view

    results = [path for path in paths if path.suffix == ".json"]
    if len(results) > 1:
        raise NotAFile(f"{' and '.join(map(str, results))}: give one fit or one diagnosis at a time")
    sources = [path for path in paths if path not in results]
    recordings = renamed(read_runs(sources, model))
    if not results:
        return recording_view(recordings)
    table = read_json(results[0])
    if "exidyn_fit" in table:
        return fit_view(predicted(read_fit(results[0]), recordings))
    if "exidyn_diagnosis" not in table:
        raise NotAFile(f"{results[0]} is neither a fit nor a diagnosis")
    if recordings:
        raise NotAFile(f"{results[0]} contains its runs; view {', '.join(map(str, sources))} separately")
    shown = read_shown(results[0])
    return diagnosis_view(shown._replace(traces=tuple(renamed(shown.traces))))
