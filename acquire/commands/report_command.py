"""exidyn report: recordings, fits, diagnoses and comparisons on one page; exidyn view: in Rerun's viewer."""

from argparse import Namespace
from pathlib import Path

from exidyn.identification.progress import StageText
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments.command import Command, Option
from ..arguments.options import output_option, require_apart, require_file, robot_option
from ..files.given_runs import PAYLOADS
from ..files.report_files import VALID, found_files
from ..terminal.json_output import print_written, write_whole
from ..terminal.stopwatch import Stopwatch
from ..views.live_view import LOCAL, PORT, Targets

ROBOT = robot_option("for tables, which do not name their robot")
STAGES = {"read": 0.25, "predict": 0.55, "draw": 0.2}
"""Stages and their shares of the time."""


@Command(
    "Bring recordings, fits, a diagnosis and comparisons together on one HTML page that needs no other.",
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
def report_command(given: Namespace) -> None:
    """Read, bring together, write."""
    # Pages take time to import, which `view` can do without.
    from exidyn.identification.pages.report_document import joined_html

    from ..files.report_material import material

    files = found_files(given.sources)
    require_file(given.output, "--output", [one.path for one in files])
    with Stopwatch(STAGES) as progress:
        model = read_model(given.robot) if given.robot else None
        found = material(files, given.payload, model, progress)
        progress(StageText("draw", "draw the page"))
        write_whole(given.output, joined_html(found))
    print_written(given.output)


@Command(
    "Show recordings, a fit and what it predicts of them, or a diagnosis, in a window of Rerun's viewer.",
    (
        "exidyn view run.mcap other.mcap",
        "exidyn view exidyn-fit/fit.json run.mcap --save fit.rrd",
        "exidyn view exidyn-diagnosis/diagnosis.json --serve",
    ),
    (
        Option(
            "files FILE...",
            "recordings (.mcap, .csv, case folder); or fit.json and recordings; or diagnosis.json",
            Path,
        ),
        ROBOT,
        Option("--save --output -o FILE", "write a file for Rerun's viewer (.rrd) instead", Path),
        Option(
            "--serve --browser [ADDRESS:PORT]",
            f"serve it to browsers instead, until Ctrl-C; default: {LOCAL}:{PORT}, this machine only",
            alone=f"{LOCAL}:{PORT}",
        ),
    ),
)
def view_command(given: Namespace) -> None:
    """Show."""
    if given.save is not None:
        require_apart(given.save, "--save", given.files)
    from ..views.kinds import view_of  # Rerun takes a second to import, and a help text can do without
    from ..views.viewers import show

    model = read_model(given.robot) if given.robot else None
    window = given.save is None and given.serve is None
    show(view_of(given.files, model), Targets(window, given.serve, given.save))
    if given.save is not None:
        print_written(given.save)
