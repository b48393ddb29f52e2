"""exidyn identify: identify dynamics and drive gains from recordings."""

from argparse import Namespace
from pathlib import Path

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.fit.estimators import ESTIMATORS
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import fit_text, write_fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.model import Model
from exidyn.identification.pages.fit_document import report_html, summary
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.progress import StageText
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments.command import Command, Option, table_help
from ..arguments.options import (
    AS_RECORDED,
    FILTERS,
    JSON,
    VALIDATE,
    make_folder,
    output_option,
    require_file,
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
    "Identify an arm's dynamics, and its drive gains if a run carries a known payload.",
    (
        "exidyn identify run.mcap --validate other.mcap",
        "exidyn identify empty.mcap --payload loaded.mcap --mass 175 --validate other.mcap",
        "exidyn identify run.mcap --shapes stribeck_friction --json -",
    ),
    (
        Option(
            "runs RUN...",
            "recording (.mcap), or with --robot a table (.csv)",
            Path,
        ),
        *PAYLOADS,
        VALIDATE,
        robot_option("replaces the robot in the recordings"),
        Option(
            "--estimator NAME",
            f"one of {', '.join(ESTIMATORS)}, see below; default: ml with a known payload, else weighted",
            ESTIMATORS,
        ),
        AS_RECORDED,
        Option("--keep-all", "keep parameters that are indistinguishable from zero"),
        Option(
            "--shapes EFFECT...",
            "effects whose shapes are also fitted, joint by joint, such as coulomb_friction",
            default=[],
        ),
        Option("--repeat", "also fit each run, or part of a run, alone, and compare their parameters"),
        *FILTERS,
        output_option("FOLDER", Path("exidyn-fit")),
        JSON,
        Option("--view", "show measurement and prediction in Rerun's viewer"),
        Option("--save FILE", "save that view as a file (.rrd)", Path),
    ),
    table_help("estimators", ESTIMATORS),
)
def identify_command(args: Namespace) -> None:
    """Identify, print and write the fit."""
    with Stopwatch(STAGES) as progress:
        _identify(args, progress)


def _identify(args: Namespace, progress: Stopwatch) -> None:
    make_folder(args.output)
    if args.save:
        require_file(args.save, "--save", [*args.runs, *args.validate])
    model = read_model(args.robot) if args.robot else None
    progress(StageText("read", "read the recordings"))
    runs, held_out = _recordings(args, model)
    fit = identify(
        runs,
        held_out,
        model=model,
        estimator=ESTIMATORS[args.estimator] if args.estimator else None,
        filtering=Filtering(None, args.position_cutoff, args.torque_cutoff, args.standstill),
        drop=not args.keep_all,
        fitted_shapes=args.shapes,
        as_recorded=args.as_recorded,
        repeat=args.repeat,
        progress=progress,
    )
    progress.close()
    hand_over(summary(fit), fit_text(fit), args.json)
    _write(fit, args)


def _recordings(args: Namespace, model: Model | None) -> tuple[list[Recording], list[Recording]]:
    """Runs to fit and held-out runs, by the roles that recordings state."""
    read = [recording for path in args.runs for recording in import_source(path, model)]
    held_out = [recording for recording in read if recording.settings.get("role") == HELD_OUT]
    runs = [recording for recording in read if recording.settings.get("role") != HELD_OUT]
    if not runs:  # if all are validation runs, they are meant to be fitted
        runs, held_out = held_out, []
    for run in args.payload:
        runs += [carrying(recording, run) for recording in import_source(run.path, model)]
    held_out += [recording for path in args.validate for recording in import_source(path, model)]
    recordings = distinct_bodies([*runs, *held_out])
    return recordings[: len(runs)], recordings[len(runs) :]


def _write(fit: Fit, args: Namespace) -> None:
    """Write fit.json and report.html, show or save the view, and print the paths on standard error."""
    folder = args.output
    write_fit(fit, folder / "fit.json")
    (folder / "report.html").write_text(report_html(fit), encoding="utf-8")
    print_written(folder / "fit.json", folder / "report.html")
    if args.view or args.save:
        from ..views.fit_view import fit_view  # Rerun takes a second to import
        from ..views.live_view import Targets
        from ..views.viewers import show

        show(fit_view(fit), Targets(view=args.view, save=args.save))
        if args.save:
            print_written(args.save)
