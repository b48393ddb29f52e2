"""exidyn payload: identify the payload on the flange, or plan the motion for it."""

from argparse import Namespace
from pathlib import Path

from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.model import Model
from exidyn.identification.pages.payload_document import payload_table, payload_text
from exidyn.identification.payload.formats import FORMATS
from exidyn.identification.payload.payload_estimate import PayloadEstimate
from exidyn.identification.payload.weigh import weigh
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.progress import StageText
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments.command import Command, Option, WrongUse, table_help
from ..arguments.options import AS_RECORDED, JSON, filters, require_json, robot_option
from ..terminal.json_output import hand_over, json_text
from ..terminal.stopwatch import Progress, Stopwatch

STAGES = {"read": 0.1, "units": 0.3, "filter": 0.1, "estimate": 0.35, "check": 0.15}
"""Stages and their shares of the time."""


@Command(
    "Identify the payload on the flange: mass, center of mass, inertia, and 95 % intervals.",
    (
        "exidyn payload loaded.mcap --fit exidyn-fit/fit.json --for ur",
        "exidyn payload loaded.mcap --empty empty.mcap --for kuka abb",
        "exidyn payload loaded.csv --robot arm.urdf      # the widest intervals",
    ),
    (
        Option("runs RUN...", "run with the payload (.mcap, .csv); the same payload in all", Path),
        Option("--fit FIT", "fit.json of the arm without the payload: the narrowest intervals", Path),
        Option("--empty RUN...", "run without the payload, best of the same motion", Path, []),
        robot_option("replaces the robot in the recordings"),
        Option(
            "--for CONTROLLER...",
            "also print the payload as these take it, see below",
            FORMATS,
            [],
            dest="forms",
        ),
        *filters(),
        JSON,
        AS_RECORDED,
    ),
    table_help("controllers", FORMATS),
)
def payload_command(args: Namespace) -> None:
    """Identify the payload and print it."""
    require_json(args.json)
    if args.fit and args.empty:
        raise WrongUse("--fit and --empty cannot be used together: the fit already knows the empty arm")
    if args.fit and args.robot:
        raise WrongUse("--fit and --robot cannot be used together: the fit contains its robot")
    with Stopwatch(STAGES) as progress:
        progress(StageText("read", "read the recordings"))
        result = _weighed(args, progress)
    hand_over(payload_text(result, args.forms), json_text(payload_table(result, args.forms)), args.json)


def _weighed(args: Namespace, progress: Progress) -> PayloadEstimate:
    """The payload of the runs."""
    fit = read_fit(args.fit) if args.fit else None
    model = read_model(args.robot) if args.robot else None
    return weigh(
        _read(args.runs, model, fit),
        fit=fit,
        empty=_read(args.empty, model, fit),
        model=model,
        filtering=Filtering(None, args.position_cutoff, args.torque_cutoff, args.standstill),
        as_recorded=args.as_recorded,
        progress=progress,
    )


def _read(paths: list[Path], model: Model | None, fit: Fit | None) -> list[Recording]:
    """Recordings of files; tables without a robot have that of the fit."""
    arm = fit.model if model is None and fit is not None else model
    return [run for path in paths for run in import_source(path, arm)]
