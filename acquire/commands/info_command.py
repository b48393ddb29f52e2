"""exidyn info: what is inside recordings; exidyn recover: whole ones of what a crash or a bad copy left."""

import sys
from argparse import Namespace
from pathlib import Path

from exidyn.identification.errors import RecordingError
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.mcap.mcap_recover import Recovered, recover
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.text_table import paragraph

from ..arguments.command import Command, Option
from ..arguments.exit_codes import DONE, LOST
from ..arguments.options import JSON, output_option, require_file, require_json, robot_option
from ..terminal.json_output import hand_over, json_text
from ..terminal.recording_text import describe, recording_table


@Command(
    "Print what is inside recordings.",
    ("exidyn info run.mcap", "exidyn info run.mcap --json -"),
    (
        Option("runs RUN...", "recording (.mcap), table (.csv) or case folder", Path),
        robot_option("for tables, which do not name their robot"),
        JSON,
    ),
)
def info_command(given: Namespace) -> None:
    """Print what recordings hold."""
    require_json(given.json)
    model = read_model(given.robot) if given.robot else None
    recordings = [recording for path in given.runs for recording in import_source(path, model)]
    table = {"exidyn_info": 1, "recordings": [recording_table(recording) for recording in recordings]}
    hand_over("\n\n".join(map(describe, recordings)), json_text(table), given.json)


@Command(
    "Make whole recordings of those that end abruptly or are damaged; these are kept.",
    ("exidyn recover run.mcap.part", "exidyn recover cut.mcap -o whole.mcap"),
    (
        Option("runs RUN...", "recording (.mcap, .mcap.part)", Path),
        output_option("FILE", meaning="what to call the whole file"),
    ),
    f"""run.mcap.part becomes run.mcap if there is none yet, all others become
run.recovered.mcap. Exit code {LOST}: something is lost for good.""",
)
def recover_command(given: Namespace) -> int:
    """Write a whole file beside each one given, and print what it lacks."""
    if given.output and len(given.runs) > 1:
        raise RecordingError(f"--output is one name, and {len(given.runs)} files are given")
    if given.output and not given.output.exists():  # of one that does, the errors below are clearer
        require_file(given.output, "--output")
    lost = False
    for file in given.runs:
        target = given.output or target_of(file)
        found = recover(file, target)
        print(_recovered(file, target, found))
        for loss in found.lost:
            print("\n".join(paragraph(loss, " " * 8, "  lost: ")), file=sys.stderr)
        lost |= bool(found.lost)
    return LOST if lost else DONE


def target_of(file: Path) -> Path:
    """What the whole file is called."""
    whole = file.with_suffix("") if file.suffix == ".part" else file
    return whole.with_suffix(f".recovered{whole.suffix}") if whole.exists() else whole


def _recovered(file: Path, target: Path, found: Recovered) -> str:
    """What was rescued, in a line."""
    if not found.messages:
        return f"{target}: what explains the run, and not one message of it, from {file}"
    return f"{target}: {found.messages} messages in {found.seconds:.3f} s from {file}"
