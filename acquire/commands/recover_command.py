"""exidyn recover: whole recordings of what a crash or a bad copy left."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from exidyn.identify.errors import RecordingError
from exidyn.identify.recordings.mcap.mcap_recover import Recovered, recover
from exidyn.identify.text_table import paragraph

from ..arguments.common import command_parser
from ..arguments.exit_codes import DONE, LOST
from ..arguments.outputs import add_output, require_file

EXAMPLES = ("exidyn recover run.mcap.part", "exidyn recover cut.mcap -o whole.mcap")


def main(arguments: Sequence[str]) -> int:
    """Write a whole file beside each one given, and print what it lacks."""
    given = parser().parse_args(arguments)
    if given.output and len(given.runs) > 1:
        raise RecordingError(f"--output is one name, and {len(given.runs)} files are given")
    if given.output and not given.output.exists():  # of one that does, the errors below are clearer
        require_file(given.output, "--output")
    lost = False
    for file in given.runs:
        target = given.output or target_of(file)
        found = recover(file, target)
        print(describe(file, target, found))
        for loss in found.lost:
            print("\n".join(paragraph(loss, " " * 8, "  lost: ")), file=sys.stderr)
        lost |= bool(found.lost)
    return LOST if lost else DONE


def parser() -> argparse.ArgumentParser:
    """What `exidyn recover` takes."""
    found = command_parser(
        "recover",
        "Make whole recordings of those that end abruptly or are damaged; these are kept.",
        EXAMPLES,
        notes="run.mcap.part becomes run.mcap if there is none yet, all others become\n"
        "run.recovered.mcap. "
        f"Exit code {LOST}: something is lost for good.",
    )
    found.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="recording (.mcap, .mcap.part)")
    add_output(found, "FILE", meaning="what to call the whole file")
    return found


def target_of(file: Path) -> Path:
    """What the whole file is called."""
    whole = file.with_suffix("") if file.suffix == ".part" else file
    return whole.with_suffix(f".recovered{whole.suffix}") if whole.exists() else whole


def describe(file: Path, target: Path, found: Recovered) -> str:
    """What was rescued, in a line."""
    if not found.messages:
        return f"{target}: what explains the run, and not one message of it, from {file}"
    return f"{target}: {found.messages} messages in {found.seconds:.3f} s from {file}"
