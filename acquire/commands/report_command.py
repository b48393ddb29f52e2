"""exidyn report: whatever was recorded, identified, diagnosed and compared, on one page."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from exidyn.identify.pages.report_document import joined_html
from exidyn.identify.robot_files.robot_file import read_model

from ..arguments.common import add_robot, command_parser
from ..arguments.outputs import add_output, require_file
from ..files.payload_runs import add_payload_arguments
from ..files.report_files import VALID, found_files
from ..files.report_material import material
from ..terminal.json_output import print_written, write_whole
from ..terminal.stopwatch import Stopwatch

EXAMPLES = (
    "exidyn report exidyn-fit empty.mcap loaded.mcap other.mcap",
    "exidyn report exidyn-fit exidyn-diagnosis compared.json *.mcap --output arm.html",
)

STAGES = {"read": 0.25, "predict": 0.55, "draw": 0.2}
"""How their sentences begin, and their shares of the time."""


def main(arguments: Sequence[str]) -> int:
    """Read, bring together, write."""
    given = parser().parse_args(arguments)
    files = found_files(given.sources)
    require_file(given.output, "--output", [one.path for one in files])
    with Stopwatch(STAGES) as progress:
        found = material(
            files,
            given.payload,
            read_model(given.robot) if given.robot else None,
            progress,
        )
        progress("draw the page")
        write_whole(given.output, joined_html(found))
    print_written(given.output)
    return 0


def parser() -> argparse.ArgumentParser:
    """What `exidyn report` takes."""
    found = command_parser(
        "report",
        "Bring recordings, fits, a diagnosis and comparisons together on one HTML page that needs no other.",
        EXAMPLES,
    )
    found.add_argument("sources", nargs="+", type=Path, metavar="FILE", help=f"in any order: {VALID}")
    add_payload_arguments(found)
    add_robot(found, "for tables, which do not name their robot")
    add_output(found, "FILE", Path("report.html"))
    return found
