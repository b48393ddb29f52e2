"""exidyn report: recordings, fits, diagnosis and comparisons on one page; exidyn view: in Rerun's viewer."""

from argparse import Namespace
from pathlib import Path

from exidyn.identification.progress import StageText
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments.command import Command, Option
from ..arguments.options import output_option, require_apart, require_file, robot_option
from ..files.given_runs import PAYLOADS
from ..files.report_files import VALID, find_files
from ..terminal.json_output import print_written, write_whole
from ..terminal.stopwatch import Stopwatch
from ..views.live_view import LOCAL, PORT, Targets

ROBOT = robot_option("for tables, which do not contain their robot")
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
        ROBOT,
        output_option("FILE", Path("report.html")),
    ),
)
def report_command(args: Namespace) -> None:
    """Read all files, and write the page."""
    # Pages take time to import, and `view` does not need them.
    from exidyn.identification.pages.report_document import joined_html

    from ..files.report_material import read_material

    files = find_files(args.sources)
    require_file(args.output, "--output", files)
    with Stopwatch(STAGES) as progress:
        model = read_model(args.robot) if args.robot else None
        material = read_material(files, args.payload, model, progress)
        progress(StageText("draw", "draw the page"))
        write_whole(args.output, joined_html(material))
    print_written(args.output)


@Command(
    "Show recordings, a fit with its predictions, or a diagnosis in Rerun's viewer.",
    (
        "exidyn view run.mcap other.mcap",
        "exidyn view exidyn-fit/fit.json run.mcap --save fit.rrd",
        "exidyn view exidyn-diagnosis/diagnosis.json --serve",
    ),
    (
        Option(
            "files FILE...",
            "recordings (.mcap, .csv); or fit.json and recordings; or diagnosis.json",
            Path,
        ),
        ROBOT,
        Option("--save FILE", "save the view as a file (.rrd) instead", Path),
        Option(
            "--serve [ADDRESS:PORT]",
            f"serve the view to browsers instead, until Ctrl-C; default: {LOCAL}:{PORT}, this machine only",
            alone=f"{LOCAL}:{PORT}",
        ),
    ),
)
def view_command(args: Namespace) -> None:
    """Show, save or serve the view."""
    if args.save is not None:
        require_apart(args.save, "--save", args.files)
    from ..views.kinds import view_of  # Rerun takes a second to import, and help texts do not need it
    from ..views.viewers import show

    model = read_model(args.robot) if args.robot else None
    window = args.save is None and args.serve is None
    show(view_of(args.files, model), Targets(window, args.serve, args.save))
    if args.save is not None:
        print_written(args.save)
