"""exidyn diagnose: find the effects that a nominal model lacks, from recordings."""

import sys
from argparse import Namespace
from pathlib import Path

from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.improved.forward import Forward, forward
from exidyn.identification.diagnosis.refit import refit
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.diagnosis.words.diagnosis_file import as_json
from exidyn.identification.document.text import text
from exidyn.identification.errors import ExidynError
from exidyn.identification.file_names import distinct_stems
from exidyn.identification.fit.fit import Fit
from exidyn.identification.notebook import counted
from exidyn.identification.pages.diagnosis_document import diagnosis_document
from exidyn.identification.pages.shown import Shown
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.progress import StageText
from exidyn.identification.robot_files.description import NAMED

from ..arguments.command import Command, Option
from ..arguments.exit_codes import DONE, REFUSED
from ..arguments.options import AS_RECORDED, JSON, VALIDATE, filters, make_folder, output_option
from ..files.diagnosis_files import add_answer, read_answers, write_diagnosis
from ..files.given_runs import COMPARISON_CUTOFF, PAYLOADS, Case, case_folders, read_case, recorded_case
from ..terminal.json_output import hand_over, json_text, print_written
from ..terminal.stopwatch import Progress, Stopwatch

QUICK = {"read": 0.02, "ask": 0.0, "filter": 0.03, "form": 0.47, "search": 0.38, "weigh": 0.1}
"""Stages and their shares of the time with --quick."""
STAGES = {name: 0.7 * share for name, share in QUICK.items()} | {"simulate": 0.16, "identify": 0.14}
"""Stages and their shares of the time."""


@Command(
    "Find the physics that a robot's model lacks, and prove it on held-out runs.",
    (
        "exidyn diagnose robot.toml one.mcap --slow slow.mcap --validate other.mcap",
        "exidyn diagnose robot.toml one.mcap --payload loaded.mcap --mass 4 --validate other.mcap",
        "exidyn diagnose cases/c01 cases/c02 --answer answers.json",
    ),
    (
        Option(
            "sources SOURCE...",
            f"robot.toml, {NAMED} and its runs (.mcap, .csv); or case folders, which contain case.toml",
        ),
        VALIDATE,
        Option("--slow RUN...", "runs at constant low speeds", Path, []),
        *PAYLOADS,
        *filters(f"from the data; for case folders {COMPARISON_CUTOFF:g}, as their format requires"),
        output_option("FOLDER", Path("exidyn-diagnosis")),
        JSON,
        AS_RECORDED,
        Option("--answer FILE", "JSON file to which the findings of each case are added, by its name", Path),
        Option("--quick", "skip the simulation and fit.json, which take a while"),
    ),
    """A recording may state its role (identify, slow, payload, validate); runs after
--slow, --payload or --validate have that role. The more kinds of run, the more
effects can be distinguished.""",
)
def diagnose_command(args: Namespace) -> int:
    """Diagnose each case, print and write the results."""
    folders = case_folders(args.sources)
    make_folder(args.output)
    if args.answer:
        read_answers(args.answer)  # reports a damaged file before any work is done
    if folders:
        _require_no_runs(args)
        args.torque_cutoff = args.torque_cutoff or COMPARISON_CUTOFF
    if len(folders) > 1:
        if args.json:
            raise ExidynError(
                "--json takes one case; of several cases, each has its diagnosis.json below --output, and "
                "--answer collects their findings"
            )
        stems = distinct_stems([folder.resolve().name for folder in folders], "case")
        done = [_try(folder, args.output / stem, args) for folder, stem in zip(folders, stems, strict=True)]
        return DONE if all(done) else REFUSED
    _read_and_do(folders[0] if folders else None, args.output, args)
    return DONE


def _read_and_do(folder: Path | None, output: Path, args: Namespace) -> None:
    """Diagnose a case folder, or the runs of the command line if there is none."""
    with Stopwatch(QUICK if args.quick else STAGES) as progress:
        progress(StageText("read", f"read {folder or 'the recordings'}"))
        _diagnose_case(read_case(folder) if folder else recorded_case(args), output, args, progress)


def _require_no_runs(args: Namespace) -> None:
    run_options = [f"--{name}" for name in ("validate", "slow", "payload") if getattr(args, name)]
    if run_options:
        raise ExidynError(
            f"{' and '.join(run_options)} cannot be used with a case folder, whose case.toml names the runs"
        )


def _try(folder: Path, output: Path, args: Namespace) -> bool:
    """Diagnose one of several cases; return whether it succeeded."""
    try:
        _read_and_do(folder, output, args)
    except ExidynError as error:
        print(f"exidyn: {folder}: {' '.join(str(error).split())}", file=sys.stderr)
        return False
    return True


def _diagnose_case(case: Case, output: Path, args: Namespace, progress: Stopwatch) -> None:
    """Diagnose one case, print and write the results."""
    progress(StageText("ask", f"check {counted(len(case.runs), 'run')} of {case.name}"))
    filtering = Filtering(None, args.position_cutoff, args.torque_cutoff, args.standstill)
    diagnosis = diagnose(
        case.model,
        case.runs,
        case.name,
        filtering=filtering,
        as_recorded=args.as_recorded,
        progress=progress,
    )
    if args.answer:
        add_answer(diagnosis, args.answer)
    simulated = None if args.quick else _simulated(diagnosis, case, progress)
    fit = None if args.quick else _fit(diagnosis, case, filtering, progress)
    written = write_diagnosis(diagnosis, simulated, fit, output)
    progress.close()
    shown = Shown.of(diagnosis, str(output), simulated)
    hand_over(text(diagnosis_document(shown)), json_text(as_json(shown.diagnosis, str(output))), args.json)
    print_written(*written)


def _simulated(diagnosis: Diagnosis, case: Case, progress: Progress) -> Forward | None:
    """Simulation of the first held-out run, or else of the first run; None if the arm cannot be simulated."""
    runs = dict(case.runs[::-1])
    recording = runs.get(HELD_OUT) or case.runs[0][1]
    progress(StageText("simulate", f"simulate {recording.name} without and with findings"))
    try:
        return forward(diagnosis, recording)
    except ExidynError as error:
        progress(f"not simulated: {error}")
        return None


def _fit(diagnosis: Diagnosis, case: Case, filtering: Filtering, progress: Progress) -> Fit | None:
    """Fit of the model with the findings; None if the runs do not suffice."""
    progress(StageText("identify", "identify the model with the findings"))
    try:
        return refit(diagnosis, case.runs, filtering=filtering)
    except ExidynError as error:
        progress(f"no fit.json: {error}")
        return None
