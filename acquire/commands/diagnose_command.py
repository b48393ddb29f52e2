"""exidyn diagnose: find the effects that a nominal model lacks, from recordings."""

from argparse import Namespace
from pathlib import Path

from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.refit import refit
from exidyn.identification.diagnosis.words.diagnosis_file import as_json
from exidyn.identification.errors import ExidynError
from exidyn.identification.fit.fit import Fit
from exidyn.identification.notebook import counted
from exidyn.identification.pages.diagnosis_document import diagnosis_document
from exidyn.identification.pages.shown import Shown
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.progress import StageText
from exidyn.identification.recordings.recording import Recording

from ..arguments import options
from ..arguments.command import Command, Option
from ..files.given_runs import PAYLOADS, recorded_case
from ..files.result_files import write_diagnosis
from ..terminal.stopwatch import Progress, Stopwatch
from .result import Result

QUICK = {"read": 0.02, "ask": 0.0, "filter": 0.03, "form": 0.47, "search": 0.38, "weigh": 0.1}
"""Stages and their shares of the time with --quick."""
STAGES = {name: 0.84 * share for name, share in QUICK.items()} | {"identify": 0.16}
"""Stages and their shares of the time."""


@Command(
    "Find the physics that a robot's model lacks, and prove it on held-out runs.",
    (
        "exidyn diagnose one.mcap --slow slow.mcap --validate other.mcap --robot robot.toml",
        "exidyn diagnose one.mcap --payload loaded.mcap --mass 4 --validate other.mcap",
    ),
    (
        Option("runs RUN...", "recording (.mcap), or with --robot a table (.csv)", Path),
        options.robot_option("replaces the robot in the recordings"),
        options.VALIDATE,
        Option("--slow RUN...", "runs at constant low speeds", Path, []),
        *PAYLOADS,
        *options.FILTERS,
        options.output_option("FOLDER", Path("exidyn-diagnosis")),
        options.JSON,
        options.FULL,
        options.AS_RECORDED,
        Option("--quick", "skip fit.json, which takes a while"),
    ),
    """A recording may state its role (identify, slow, payload, validate); runs after
--slow, --payload or --validate have that role. The more kinds of run, the more
effects can be distinguished.""",
)
def diagnose_command(args: Namespace) -> Result:
    """Diagnose the runs, print and write the results."""
    options.make_folder(args.output)
    with Stopwatch(QUICK if args.quick else STAGES) as progress:
        progress(StageText("read", "read the recordings"))
        model, runs = recorded_case(args)
        progress(StageText("ask", f"check {counted(len(runs), 'run')} of {model.robot.name}"))
        filtering = Filtering(None, args.position_cutoff, args.torque_cutoff, args.standstill)
        diagnosis = diagnose(
            model,
            runs,
            model.robot.name,
            filtering=filtering,
            as_recorded=args.as_recorded,
            progress=progress,
        )
        fit = None if args.quick else _fit(diagnosis, runs, filtering, progress)
        written = write_diagnosis(diagnosis, fit, args.output)
    shown = Shown.of(diagnosis, str(args.output))
    return Result(diagnosis_document(shown), as_json(shown.diagnosis, str(args.output)), written)


def _fit(
    diagnosis: Diagnosis, runs: list[tuple[str, Recording]], filtering: Filtering, progress: Progress
) -> Fit | None:
    """Fit of the model with the findings; None if the runs do not suffice."""
    progress(StageText("identify", "identify the model with the findings"))
    try:
        return refit(diagnosis, runs, filtering=filtering)
    except ExidynError as error:
        progress(f"no fit.json: {error}")
        return None
