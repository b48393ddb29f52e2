"""exidyn info: contents of recordings, and recordings rebuilt after a crash or a bad copy."""

import sys
from argparse import Namespace
from pathlib import Path

from exidyn.identification.errors import RecordingError
from exidyn.identification.recordings.mcap.mcap_records import recover
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.text_table import paragraph

from ..arguments.command import Command, Option, refuse_with, refuse_without
from ..arguments.options import FULL, JSON, output_option, require_file, robot_option
from ..arguments.parser import DONE, LOST
from ..files.given_runs import read_runs
from ..terminal.recording_text import recording_table, recordings_document
from .result import Result

OUTPUT = output_option("FILE", meaning="name of the repaired file, with --repair")
ROBOT = robot_option("for tables, which do not contain their robot")


@Command(
    "Print the contents of recordings, or repair recordings that end abruptly or are damaged.",
    ("exidyn info run.mcap", "exidyn info run.mcap --json -", "exidyn info --repair run.mcap.part"),
    (
        Option("runs RUN...", "recording (.mcap; .mcap.part with --repair) or table (.csv)", Path),
        ROBOT,
        JSON,
        FULL,
        Option(
            "--repair", "write what is readable of damaged recordings to new files; the originals are kept"
        ),
        OUTPUT,
    ),
    f"""Repaired, run.mcap.part becomes run.mcap if that does not exist; other files become
run.recovered.mcap. Exit code {LOST}: part of the recording is lost.""",
)
def info_command(args: Namespace) -> Result | int:
    """Print the contents of recordings, or repair them."""
    if args.repair:
        refuse_with("--repair", args, [ROBOT, JSON, FULL])
        return _repair(args.runs, args.output)
    refuse_without("--repair", args, [OUTPUT])
    model = read_model(args.robot) if args.robot else None
    recordings = read_runs(args.runs, model)
    table = {"exidyn_info": 1, "recordings": [recording_table(recording) for recording in recordings]}
    return Result(recordings_document(recordings), table)


def _repair(files: list[Path], output: Path | None) -> int:
    """Write a recovered file beside each damaged one, and print what is lost."""
    if output and len(files) > 1:
        raise RecordingError(f"--output is one file, but there are {len(files)} recordings; omit it")
    if output and not output.exists():  # for an existing file, the errors below are clearer
        require_file(output, "--output")
    lost = False
    for file in files:
        target = output or target_of(file)
        recovered = recover(file, target)
        saved = f"{recovered.messages} messages in {recovered.seconds:.3f} s"
        print(f"{target}: {saved if recovered.messages else 'head of the run, but no messages,'} from {file}")
        for loss in recovered.lost:
            print("\n".join(paragraph(loss, " " * 8, "  lost: ")), file=sys.stderr)
        lost |= bool(recovered.lost)
    return LOST if lost else DONE


def target_of(file: Path) -> Path:
    """Default path of the recovered file."""
    complete = file.with_suffix("") if file.suffix == ".part" else file
    return complete.with_suffix(f".recovered{complete.suffix}") if complete.exists() else complete
