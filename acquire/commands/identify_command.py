"""exidyn identify: identify dynamics and drive gains from recordings."""

import shlex
from argparse import Namespace
from pathlib import Path

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.fit.estimators import ESTIMATORS
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import fit_text, write_fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.verdict import JointState, joint_verdicts
from exidyn.identification.model import Model
from exidyn.identification.pages.fit_document import fit_document
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.progress import StageText
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments import options
from ..arguments.command import Command, Option, table_help
from ..files.given_runs import PAYLOADS, carrying, diagnose_words, distinct_bodies, read_runs
from ..terminal.stopwatch import Stopwatch
from .import_command import DEGREES, UNITS, import_options
from .result import Result, later

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
        Option("runs RUN...", "recording (.mcap), or with --robot a table (.csv)", Path),
        *PAYLOADS,
        options.VALIDATE,
        options.robot_option("replaces the robot in the recordings"),
        DEGREES,
        UNITS,
        Option(
            "--estimator NAME",
            f"one of {', '.join(ESTIMATORS)}, see below; default: ml with a known payload, else weighted",
            ESTIMATORS,
        ),
        options.AS_RECORDED,
        Option(
            "--shapes EFFECT...",
            "effects whose shapes are also fitted, joint by joint, such as coulomb_friction",
            default=[],
        ),
        Option("--repeat", "also fit each run, or part of a run, alone, and compare their parameters"),
        *options.FILTERS,
        options.output_option("FOLDER", Path("exidyn-fit")),
        options.JSON,
        options.FULL,
        *options.view_options("measurement and prediction"),
    ),
    table_help("estimators", ESTIMATORS),
)
def identify_command(args: Namespace) -> Result:
    """Identify, print and write the fit."""
    options.make_folder(args.output)
    options.require_file(args.save, "--save", [*args.runs, *args.validate])
    model = read_model(args.robot) if args.robot else None
    with Stopwatch(STAGES) as progress:
        progress(StageText("read", "read the recordings"))
        runs, held_out = _recordings(args, model)
        fit = identify(
            runs,
            held_out,
            model=model,
            estimator=ESTIMATORS[args.estimator] if args.estimator else None,
            filtering=Filtering(None, args.position_cutoff, args.torque_cutoff, args.standstill),
            fitted_shapes=args.shapes,
            as_recorded=args.as_recorded,
            repeat=args.repeat,
            progress=progress,
        )
    file, report = args.output / "fit.json", args.output / "report.html"
    write_fit(fit, file)
    following = [_next(args, fit, file)]
    return Result(fit_document(fit), fit_text(fit), [file], report, following, later("fit_view", fit))


def _next(args: Namespace, fit: Fit, file: Path) -> str:
    """The command that tells what recordings show beyond the model, or an export if there is nothing."""
    above = any(joint.state is JointState.FAR_ABOVE for joint in joint_verdicts(fit))
    if above and not import_options(args):
        return diagnose_words(args, args.robot)
    return f"export {shlex.quote(str(file))} --to mjcf"


def _recordings(args: Namespace, model: Model | None) -> tuple[list[Recording], list[Recording]]:
    """Runs to fit and held-out runs, by the roles that recordings state."""
    options = import_options(args)
    read = read_runs(args.runs, model, **options)
    held_out = [recording for recording in read if recording.settings.get("role") == HELD_OUT]
    runs = [recording for recording in read if recording.settings.get("role") != HELD_OUT]
    if not runs:  # if all are validation runs, they are meant to be fitted
        runs, held_out = held_out, []
    for loaded in args.payload:
        runs += [carrying(run, loaded) for run in read_runs([loaded.path], model, **options)]
    held_out += read_runs(args.validate, model, **options)
    recordings = distinct_bodies([*runs, *held_out])
    return recordings[: len(runs)], recordings[len(runs) :]
