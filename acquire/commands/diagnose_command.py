"""exidyn diagnose: a nominal robot and its recordings in; what the model leaves out, out."""

import sys
from argparse import Namespace
from pathlib import Path

from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.diagnose import Diagnosed, diagnosed
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
from ..arguments.options import AS_RECORDED, JSON, VALIDATE, filters, make_folder, output_option, require_json
from ..files.diagnosis_files import add_answer, read_answers, write_diagnosis
from ..files.given_runs import COMPARISON_CUTOFF, PAYLOADS, Case, case_folders, read_case, recorded_case
from ..terminal.json_output import hand_over, json_text, print_written
from ..terminal.stopwatch import Progress, Stopwatch

QUICK = {"read": 0.02, "ask": 0.0, "filter": 0.03, "form": 0.47, "search": 0.38, "weigh": 0.1}
"""Stages and their shares of the time."""
STAGES = {name: 0.7 * share for name, share in QUICK.items()} | {"simulate": 0.16, "identify": 0.14}


@Command(
    "Find the physics that a robot's model leaves out, and prove it on runs held out.",
    (
        "exidyn diagnose robot.toml one.mcap --slow slow.mcap --validate other.mcap",
        "exidyn diagnose robot.toml one.mcap --payload loaded.mcap --mass 4 --validate other.mcap",
        "exidyn diagnose cases/c01 cases/c02 --answer answers.json",
    ),
    (
        Option(
            "sources SOURCE...",
            f"robot.toml, {NAMED} and its runs (.mcap, .csv); or folders with case.toml, each a case",
        ),
        VALIDATE,
        Option("--slow RUN...", "runs at constant low speeds", Path, []),
        *PAYLOADS,
        *filters(f"from the data; for case folders {COMPARISON_CUTOFF:g}, the filter of their format"),
        output_option("FOLDER", Path("exidyn-diagnosis")),
        JSON,
        AS_RECORDED,
        Option("--answer FILE", "JSON in which each case's findings are put, by its name", Path),
        Option("--quick", "without simulation and without fit.json, which take a while"),
    ),
    """Runs contain their role (identify, slow, payload, validate) where recorded so;
what comes behind an option is for that. The more kinds of run, the more effects
can be distinguished.""",
)
def diagnose_command(given: Namespace) -> int:
    """Diagnose, print, write; every case for itself."""
    require_json(given.json)
    folders = case_folders(given.sources)
    make_folder(given.output)
    if given.answer:
        read_answers(given.answer)  # before any work is done for it
    if folders:
        _require_no_runs(given)
        given.torque_cutoff = given.torque_cutoff or COMPARISON_CUTOFF
    if len(folders) > 1:
        _require_no_json(given)
        stems = distinct_stems([folder.resolve().name for folder in folders], "case")
        done = [_try(folder, given.output / stem, given) for folder, stem in zip(folders, stems, strict=True)]
        return DONE if all(done) else REFUSED
    _read_and_do(folders[0] if folders else None, given.output, given)
    return DONE


def _read_and_do(folder: Path | None, output: Path, given: Namespace) -> None:
    """Diagnose a case folder, or the runs of the command line where there is none."""
    with Stopwatch(QUICK if given.quick else STAGES) as progress:
        progress(StageText("read", f"read {folder or 'the recordings'}"))
        diagnose_case(read_case(folder) if folder else recorded_case(given), output, given, progress)


def _require_no_runs(given: Namespace) -> None:
    beside = [f"--{name}" for name in ("validate", "slow", "payload") if getattr(given, name)]
    if beside:
        raise ExidynError(f"{' and '.join(beside)} beside a case folder, whose case.toml names the runs")


def _require_no_json(given: Namespace) -> None:
    """Raise where one JSON is asked for of several cases."""
    if given.json:
        raise ExidynError(
            "--json takes one case; of several, each has its diagnosis.json below --output, and --answer "
            "collects their findings"
        )


def _try(folder: Path, output: Path, given: Namespace) -> bool:
    """Diagnose one case of several; whether that could be done."""
    try:
        _read_and_do(folder, output, given)
    except ExidynError as error:
        print(f"exidyn: {folder}: {' '.join(str(error).split())}", file=sys.stderr)
        return False
    return True


def diagnose_case(case: Case, output: Path, given: Namespace, progress: Stopwatch) -> Diagnosed:
    """Diagnose one case, print and write what came out."""
    progress(StageText("ask", f"ask {counted(len(case.runs), 'run')} of {case.name}"))
    filtering = Filtering(None, given.position_cutoff, given.torque_cutoff, given.standstill)
    found = diagnosed(
        case.model,
        case.runs,
        case.name,
        filtering=filtering,
        as_recorded=given.as_recorded,
        progress=progress,
        before=case.before,
    )
    diagnosis = found.diagnosis
    if given.answer:
        add_answer(diagnosis, given.answer)
    simulated = None if given.quick else _simulated(diagnosis, case, progress)
    fit = None if given.quick else _fit(diagnosis, case, filtering, progress)
    written = write_diagnosis(diagnosis, simulated, fit, output)
    progress.close()
    shown = Shown.of(diagnosis, str(output), simulated)
    hand_over(text(diagnosis_document(shown)), json_text(as_json(shown.diagnosis, str(output))), given.json)
    print_written(*written)
    return found


def _simulated(diagnosis: Diagnosis, case: Case, progress: Progress) -> Forward | None:
    """The first run held out in simulation, or the first run; None where the arm cannot be simulated."""
    runs = dict(case.runs[::-1])
    recording = runs.get(HELD_OUT) or case.runs[0][1]
    progress(StageText("simulate", f"simulate {recording.name} before and after"))
    try:
        return forward(diagnosis, recording)
    except ExidynError as error:
        progress(f"not simulated: {error}")
        return None


def _fit(diagnosis: Diagnosis, case: Case, filtering: Filtering, progress: Progress) -> Fit | None:
    """The model with what was found, identified again; None where the runs cannot carry that."""
    progress(StageText("identify", "identify the model again with what was found"))
    try:
        return refit(diagnosis, case.runs, filtering=filtering)
    except ExidynError as error:
        progress(f"no fit.json: {error}")
        return None
