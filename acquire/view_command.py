"""exidyn view: recordings, a fit or a diagnosis in Rerun."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from exidyn.identify.robot_file import builtin_names, read_model

from .live.targets import LOCAL, PORT, Targets

EXAMPLES = """\
examples:
  exidyn view run.mcap other.mcap
  exidyn view exidyn-fit/fit.json run.mcap -o fit.rrd
  exidyn view exidyn-diagnosis/diagnosis.json --browser"""


def main(arguments: Sequence[str]) -> int:
    """Show."""
    given = _parser().parse_args(arguments)
    from .views.kinds import view_of  # Rerun takes a second to import, and a help text can do without
    from .views.screen import show

    model = read_model(given.robot) if given.robot else None
    window = given.output is None and given.browser is None
    show(view_of(given.files, model), Targets(window, given.browser, given.output))
    if given.output is not None:
        print(f"written: {given.output}", file=sys.stderr)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="exidyn view",
        description="Show recordings, a fit and what it predicts of them, or a diagnosis, in a window of "
        "Rerun's viewer.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="recordings (.mcap, .csv, case folder); or fit.json and recordings; or diagnosis.json",
    )
    parser.add_argument(
        "--robot",
        metavar="ROBOT",
        help="for tables, which do not say of which robot they are: robot.toml or .urdf, or built in: "
        + ", ".join(builtin_names()),
    )
    parser.add_argument(
        "--output", "-o", "--save", type=Path, metavar="RRD", help="write a file for Rerun's viewer instead"
    )
    parser.add_argument(
        "--browser",
        "--serve",
        nargs="?",
        const=f"{LOCAL}:{PORT}",
        metavar="ADDRESS:PORT",
        help=f"serve it to browsers instead, until Ctrl-C; default: {LOCAL}:{PORT}, this machine only",
    )
    return parser
