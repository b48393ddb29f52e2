"""exidyn report: recordings, fits, a diagnosis and comparisons on one page."""

from argparse import Namespace
from pathlib import Path

from exidyn.identification.progress import StageText
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments.command import Command, Option
from ..arguments.options import output_option, require_file, robot_option
from ..files.given_runs import PAYLOADS
from ..files.report_files import VALID, find_files
from ..terminal.json_output import write_whole
from ..terminal.stopwatch import Stopwatch
from .result import Result

STAGES = {"read": 0.25, "predict": 0.55, "draw": 0.2}
"""Stages and their shares of the time."""


@Command(
    "Put recordings, fits, a diagnosis and comparisons on one self-contained HTML page.",
    (
        "exidyn report exidyn-fit empty.mcap loaded.mcap other.mcap",
        "exidyn report exidyn-fit exidyn-diagnosis compared.json *.mcap --output arm.html",
    ),
    (
        Option("sources FILE...", f"in any order: {VALID}", Path),
        *PAYLOADS,
        robot_option("for tables, which do not contain their robot"),
        output_option("FILE", Path("report.html")),
    ),
)
def report_command(args: Namespace) -> Result:
    """Read all files, and write the page."""
    # Pages take time to import, which help texts do not need.
    from exidyn.identification.pages.report_document import joined_html

    from ..files.report_material import read_material

    files = find_files(args.sources)
    require_file(args.output, "--output", files)
    with Stopwatch(STAGES) as progress:
        model = read_model(args.robot) if args.robot else None
        material = read_material(files, args.payload, model, progress)
        progress(StageText("draw", "draw the page"))
        write_whole(args.output, joined_html(material))
    return Result(written=[args.output])
