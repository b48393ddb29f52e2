"""exidyn identify: recordings in; a table, fit.json, a report and a view out."""

from argparse import Namespace
from pathlib import Path

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.fit.estimators import ESTIMATORS
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import fit_text, write_fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.model import Model
from exidyn.identification.pages.fit_document import summary
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.progress import StageText
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments.command import Command, Option, table_help
from ..arguments.options import (
    AS_RECORDED,
    JSON,
    VALIDATE,
    filters,
    make_folder,
    output_option,
    require_file,
    require_json,
    robot_option,
)
from ..files.given_runs import PAYLOADS, carrying, distinct_bodies
from ..terminal.json_output import hand_over, print_written
from ..terminal.stopwatch import Stopwatch

STAGES = {
    "read": 0.1,
    "units": 0.5,
    "filter": 0.08,
    "shapes": 0.0,
    "base": 0.02,
    "form": 0.1,
    "estimate": 0.15,
    "compare": 0.05,
}
"""Stages and their shares of the time."""


@Command(
    "Identify an arm's dynamics, and its drive gains where a run carries a known payload.",
    (
        "exidyn identify run.mcap --validate other.mcap",
        "exidyn identify empty.mcap --payload loaded.mcap --mass 175 --validate other.mcap",
        "exidyn identify run.mcap --shapes stribeck_friction --json -",
    ),
    (
        Option(
            "runs RUN...",
            "recording (.mcap), or with --robot a table (.csv); a folder with case.toml gives all its runs",
            Path,
        ),
        *PAYLOADS,
        VALIDATE,
        robot_option("in place of the one inside the recordings"),
        Option(
            "--estimator NAME",
            f"one of {', '.join(ESTIMATORS)}, see below; by default ml with a known payload, else weighted",
            ESTIMATORS,
        ),
        AS_RECORDED,
        Option("--keep-all", "keep parameters the data do not support"),
        Option(
            "--shapes --fit-shapes EFFECT...",
            "effects whose shapes are fitted as well, joint by joint, such as coulomb_friction",
            default=[],
        ),
        *filters(),
        output_option("FOLDER", Path("exidyn-fit")),
        JSON,
        Option("--view", "show measured and predicted in Rerun's viewer"),
        Option("--save FILE", "save that view as a file (.rrd)", Path),
    ),
    table_help("estimators", ESTIMATORS),
)
def identify_command(given: Namespace) -> None:
    """Identify, print, write."""
    with Stopwatch(STAGES) as progress:
        _identify(given, progress)


def _identify(given: Namespace, progress: Stopwatch) -> None:
    make_folder(given.output)
    require_json(given.json)
    if given.save:
        require_file(given.save, "--save", [*given.runs, *given.validate])
    model = read_model(given.robot) if given.robot else None
    progress(StageText("read", "read the recordings"))
    runs, held_out = _recordings(given, model)
    fit = identify(
        runs,
        held_out,
        model=model,
        estimator=ESTIMATORS[given.estimator] if given.estimator else None,
        filtering=Filtering(None, given.position_cutoff, given.torque_cutoff, given.standstill),
        drop=not given.keep_all,
        fitted_shapes=given.shapes,
        as_recorded=given.as_recorded,
        progress=progress,
    )
    progress.close()
    hand_over(summary(fit), fit_text(fit), given.json)
    _write(fit, given)


def _recordings(given: Namespace, model: Model | None) -> tuple[list[Recording], list[Recording]]:
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


def _write(fit: Fit, given: Namespace) -> None:
    """Write fit.json and report.html, and show or save the view; print where on standard error."""
    from exidyn.identification.pages.fit_document import write_report

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
