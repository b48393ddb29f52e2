"""exidyn identify: recordings in; a table, fit.json, a report and a view out."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from exidyn.identify.diagnosis.runs.usable import HELD_OUT
from exidyn.identify.fit.estimators import ESTIMATORS
from exidyn.identify.fit.fit import Fit
from exidyn.identify.fit.fit_file import fit_text, write_fit
from exidyn.identify.fit.identification import identify
from exidyn.identify.model import Model
from exidyn.identify.pages.fit_document import summary
from exidyn.identify.recordings.importers import import_source
from exidyn.identify.recordings.recording import Recording
from exidyn.identify.robot_files.robot_file import read_model

from ..arguments.common import add_robot, command_parser, table_help
from ..arguments.filters import add_filters, filtering_of
from ..arguments.outputs import add_json, add_output, make_folder, require_file, require_json
from ..files.payload_runs import add_payload_arguments, carrying, distinct_bodies
from ..terminal.json_output import hand_over, print_written
from ..terminal.stopwatch import Stopwatch

EXAMPLES = (
    "exidyn identify run.mcap --validate other.mcap",
    "exidyn identify empty.mcap --payload loaded.mcap --mass 175 --validate other.mcap",
    "exidyn identify run.mcap --shapes stribeck_friction --json -",
)

STAGES = {
    "read": 0.2,
    "filter": 0.15,
    "fit the": 0.0,
    "find": 0.03,
    "form": 0.22,
    "estimate": 0.3,
    "compare": 0.1,
}
"""How their sentences begin, and their shares of the time."""


def main(arguments: Sequence[str]) -> int:
    """Identify, print, write."""
    with Stopwatch(STAGES) as progress:
        run(arguments, progress)
    return 0


def run(arguments: Sequence[str], progress: Stopwatch) -> Fit:
    """Do what the command does, and return the fit."""
    given = parser().parse_args(arguments)
    make_folder(given.output)
    require_json(given.json)
    if given.save:
        require_file(given.save, "--save", [*given.runs, *given.validate])
    model = read_model(given.robot) if given.robot else None
    progress("read the recordings")
    runs, held_out = _recordings(given, model)
    fit = identify(
        runs,
        held_out,
        model=model,
        estimator=ESTIMATORS[given.estimator] if given.estimator else None,
        filtering=filtering_of(given),
        drop=not given.keep_all,
        fitted_shapes=given.shapes,
        progress=progress,
    )
    progress.close()
    hand_over(summary(fit), fit_text(fit), given.json)
    _write(fit, given)
    return fit


def parser() -> argparse.ArgumentParser:
    """What `exidyn identify` takes."""
    found = command_parser(
        "identify",
        "Identify an arm's dynamics, and its drive gains where a run carries a known payload.",
        EXAMPLES,
        table_help("estimators", ESTIMATORS),
    )
    found.add_argument(
        "runs",
        nargs="+",
        type=Path,
        metavar="RUN",
        help="recording (.mcap), or with --robot a table (.csv); a folder with case.toml gives all its runs",
    )
    add_payload_arguments(found)
    found.add_argument(
        "--validate", nargs="+", type=Path, default=[], metavar="RUN", help="runs that are only predicted"
    )
    add_robot(found, "in place of the one inside the recordings")
    found.add_argument(
        "--estimator",
        choices=ESTIMATORS,
        metavar="NAME",
        help=f"one of {', '.join(ESTIMATORS)}, see below; by default ml with a known payload, else weighted",
    )
    found.add_argument("--keep-all", action="store_true", help="keep parameters the data do not support")
    found.add_argument(
        "--shapes",
        "--fit-shapes",
        nargs="+",
        default=[],
        metavar="EFFECT",
        help="effects whose shapes are fitted as well, joint by joint, such as coulomb_friction",
    )
    add_filters(found)
    add_output(found, "FOLDER", Path("exidyn-fit"))
    add_json(found)
    found.add_argument("--view", action="store_true", help="show measured and predicted in Rerun's viewer")
    found.add_argument("--save", type=Path, metavar="FILE", help="save that view as a file (.rrd)")
    return found


def _recordings(given: argparse.Namespace, model: Model | None) -> tuple[list[Recording], list[Recording]]:
    """Runs to identify from and runs held out; a case folder names them."""
    read = [recording for path in given.runs for recording in import_source(path, model)]
    held_out = [recording for recording in read if recording.settings.get("role") == HELD_OUT]
    runs = [recording for recording in read if recording.settings.get("role") != HELD_OUT]
    if not runs:  # whoever gives only validation runs as RUN means them
        runs, held_out = held_out, []
    for run in given.payload:
        runs += [carrying(recording, run) for recording in import_source(run.path, model)]
    held_out += [recording for path in given.validate for recording in import_source(path, model)]
    every = distinct_bodies([*runs, *held_out])
    return every[: len(runs)], every[len(runs) :]


def _write(fit: Fit, given: argparse.Namespace) -> None:
    """Write fit.json and report.html, and show or save the view; print where on standard error."""
    from exidyn.identify.pages.fit_document import write_report

    folder = given.output
    write_fit(fit, folder / "fit.json")
    write_report(fit, folder / "report.html")
    print_written(folder / "fit.json", folder / "report.html")
    if given.view or given.save:
        from ..views.fit_view import fit_view  # Rerun takes a second to import
        from ..views.live_view import Targets
        from ..views.viewers import show

        show(fit_view(fit), Targets(view=given.view, save=given.save))
        if given.save:
            print_written(given.save)
