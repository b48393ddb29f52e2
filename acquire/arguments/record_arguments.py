"""The command line of exidyn record."""

import argparse
from pathlib import Path

from exidyn.drivers import known_drivers

from .common import add_body, add_plan, add_robot, command_parser, name_lines, percent
from .outputs import add_json, add_output
from .run_options import add_driving, add_stops

EXAMPLES = (
    "exidyn record trajectory.toml --robot kr270    # a simulated arm",
    "exidyn record trajectory.toml --robot robot.toml --controller cell.toml --speed 10 --view",
    "exidyn record trajectory.toml --robot robot.toml --controller cell.toml --mass 175 -o loaded.mcap",
)


def parser() -> argparse.ArgumentParser:
    """What `exidyn record` takes."""
    settings = "drivers ('exidyn drivers DRIVER' lists the settings of one)"
    found = command_parser(
        "record",
        "Play a planned motion on a controller and record the run.",
        EXAMPLES,
        name_lines(settings, {name: entry.purpose for name, entry in known_drivers().items()}),
        usage="exidyn record [-h] TRAJECTORY --robot ROBOT [option ...]",
    )
    add_plan(found)
    add_robot(found, required=True)
    add_output(found, "FILE", meaning="default: run.mcap, run-2.mcap, ...")
    add_json(found)
    found.add_argument("--name", metavar="NAME", help="what to call the run; default: the name of the file")
    found.add_argument(
        "--note", default="", metavar="TEXT", help="whatever explains the run, kept in the file"
    )
    add_driving(found.add_argument_group("controller"))
    _motion(found.add_argument_group("motion"))
    add_stops(found.add_argument_group("what stops the run"))
    add_body(found.add_argument_group("what hangs on the flange"))
    _view(found.add_argument_group("live view"))
    return found


def _motion(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--speed", type=percent, default=1.0, metavar="PERCENT", help="of the planned one; default: 100"
    )
    group.add_argument("--long", action="store_true", help="a run of more than an hour is meant")
    group.add_argument(
        "--approach",
        action="store_true",
        help="go slowly to where the motion begins, from wherever the arm is",
    )
    group.add_argument(
        "--packages",
        type=Path,
        nargs="+",
        action="extend",
        default=[],
        metavar="FOLDER",
        help="where meshes are",
    )
    group.add_argument("--no-collision", action="store_true", help="do not look at the URDF's geometry")
    group.add_argument("--dry-run", action="store_true", help="only rehearse on the mock, and record that")
    group.add_argument("--no-rehearsal", action="store_true", help="do not rehearse on the mock before")


def _view(group: argparse._ArgumentGroup) -> None:
    group.add_argument("--view", action="store_true", help="in Rerun's viewer")
    group.add_argument(
        "--serve",
        nargs="?",
        const="127.0.0.1:9090",
        metavar="ADDRESS:PORT",
        help="in a browser; default: 127.0.0.1:9090, which only this machine reaches",
    )
    group.add_argument("--save", type=Path, metavar="FILE", help="as a file for Rerun's viewer (.rrd)")
