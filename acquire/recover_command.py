"""exidyn recover: whole recordings of what a crash or a bad copy left."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from exidyn.identify.errors import RecordingError
from exidyn.identify.mcap_recover import Recovered, recover
from exidyn.identify.text_table import paragraph

LOST = 3
"""Exit code where something could not be rescued."""


def main(arguments: Sequence[str]) -> int:
    """Write a whole file beside each one given, and say what it lacks."""
    parser = argparse.ArgumentParser(
        prog="exidyn recover",
        description="Make whole recordings of those that end abruptly or are damaged; these are kept.",
        epilog="run.mcap.part becomes run.mcap if there is none yet, all others become run.recovered.mcap. "
        f"Exit code {LOST}: something is lost for good.",
    )
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="recording (.mcap, .mcap.part)")
    parser.add_argument("--output", type=Path, metavar="MCAP", help="what to call the whole file")
    given = parser.parse_args(arguments)
    if given.output and len(given.files) > 1:
        raise RecordingError(f"--output is one name, and {len(given.files)} files are given")
    lost = False
    for file in given.files:
        target = given.output or target_of(file)
        found = recover(file, target)
        print(describe(file, target, found))
        for loss in found.lost:
            print("\n".join(paragraph(loss, " " * 8, "  lost: ")), file=sys.stderr)
        lost |= bool(found.lost)
    return LOST if lost else 0


def target_of(file: Path) -> Path:
    """What the whole file is called."""
    whole = file.with_suffix("") if file.suffix == ".part" else file
    return whole.with_suffix(f".recovered{whole.suffix}") if whole.exists() else whole


def describe(file: Path, target: Path, found: Recovered) -> str:
    """What was rescued, in a line."""
    if not found.messages:
        return f"{target}: what explains the run, and not one message of it, from {file}"
    return f"{target}: {found.messages} messages in {found.seconds:.3f} s from {file}"
