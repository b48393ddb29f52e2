"""exidyn info: what is inside a recording."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from exidyn.identify.recordings.importers import import_source
from exidyn.identify.robot_files.robot_file import read_model

from ..arguments.common import add_robot, command_parser
from ..arguments.outputs import add_json, require_json
from ..terminal.json_output import hand_over, json_text
from ..terminal.recording_text import describe, recording_table

EXAMPLES = ("exidyn info run.mcap", "exidyn info run.mcap --json -")


def main(arguments: Sequence[str]) -> int:
    """Print what a recording holds."""
    given = parser().parse_args(arguments)
    require_json(given.json)
    model = read_model(given.robot) if given.robot else None
    recordings = [recording for path in given.runs for recording in import_source(path, model)]
    table = {"exidyn_info": 1, "recordings": [recording_table(recording) for recording in recordings]}
    hand_over("\n\n".join(map(describe, recordings)), json_text(table), given.json)
    return 0


def parser() -> argparse.ArgumentParser:
    """What `exidyn info` takes."""
    found = command_parser("info", "Print what is inside recordings.", EXAMPLES)
    found.add_argument(
        "runs", nargs="+", type=Path, metavar="RUN", help="recording (.mcap), table (.csv) or case folder"
    )
    add_robot(found, "for tables, which do not name their robot")
    add_json(found)
    return found
