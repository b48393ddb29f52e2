"""The command line of exidyn record."""

import argparse
from pathlib import Path

from exidyn.drivers import DRIVERS
from exidyn.identify.robot_file import builtin_names

EXAMPLE = """\
examples:
  exidyn record trajectory.toml --robot kr270                              # a simulated arm
  exidyn record trajectory.toml --robot robot.toml --controller cell.toml --speed 10 --view
  exidyn record trajectory.toml --robot robot.toml --controller cell.toml --mass 175 --output loaded.mcap"""


def parser() -> argparse.ArgumentParser:
    """What `exidyn record` takes."""
    width = max(map(len, DRIVERS))
    drivers = "\n".join(f"  {name:<{width}}  {entry.purpose}" for name, entry in DRIVERS.items())
    found = argparse.ArgumentParser(
        prog="exidyn record",
        usage="exidyn record [-h] TRAJECTORY --robot ROBOT [option ...]",  # all of them would hide an error
        description="Play a planned motion on a controller and record the run.",
        epilog=f"{EXAMPLE}\n\ndrivers ('exidyn drivers NAME' lists the settings of one):\n{drivers}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    found.add_argument(
        "plan", type=Path, metavar="TRAJECTORY", help="trajectory file (.toml) of exidyn excite"
    )
    found.add_argument(
        "--robot",
        required=True,
        metavar="ROBOT",
        help="robot.toml or .urdf, or built in: " + ", ".join(builtin_names()),
    )
    found.add_argument("--output", type=Path, metavar="MCAP", help="default: run.mcap, run-2.mcap, ...")
    found.add_argument("--name", help="what to call the run; default: the name of the file")
    found.add_argument("--note", default="", help="whatever explains the run, kept in the file")
    _controller(found.add_argument_group("controller"))
    _motion(found.add_argument_group("motion"))
    _stops(found.add_argument_group("what stops the run"))
    _payload(found.add_argument_group("what hangs on the flange"))
    _view(found.add_argument_group("live view"))
    return found


def _controller(group: argparse._ArgumentGroup) -> None:
    group.add_argument("--driver", metavar="NAME", help="default: that of the controller file, or mock")
    group.add_argument(
        "--controller", type=Path, metavar="TOML", help="driver and settings, as 'exidyn drivers NAME' prints"
    )
    group.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="one setting, before those of the file; may be repeated",
    )
    group.add_argument("--plant", metavar="ROBOT", help="what the mock's arm really is; default: ROBOT")
    group.add_argument("--seed", type=int, default=0, help="of the mock's noise")
    group.add_argument(
        "--yes", action="store_true", help="do not ask; see docs/record.md for when that is allowed"
    )


def _motion(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--speed", type=percent, default=1.0, metavar="%", help="of the planned one; default: 100"
    )
    group.add_argument(
        "--approach",
        action="store_true",
        help="go slowly to where the motion begins, from wherever the arm is",
    )
    group.add_argument(
        "--packages", type=Path, action="append", default=[], metavar="FOLDER", help="of meshes"
    )
    group.add_argument("--no-collision", action="store_true", help="do not look at the URDF's geometry")
    group.add_argument("--dry-run", action="store_true", help="only rehearse on the mock, and record that")
    group.add_argument("--no-rehearsal", action="store_true", help="do not rehearse on the mock before")


def _stops(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--tracking", type=positive, default=2.0, metavar="DEG", help="away from the command; default: 2"
    )
    group.add_argument(
        "--current",
        type=positive,
        nargs="+",
        metavar="A",
        help="one, or one a joint; default: by the torque limits",
    )
    group.add_argument("--temperature", type=positive, default=85.0, metavar="DEGC", help="default: 85")


def _payload(group: argparse._ArgumentGroup) -> None:
    group.add_argument("--mass", type=positive, metavar="KG", help="its mass")
    group.add_argument("--com", type=float, nargs=3, metavar=("X", "Y", "Z"), help="centre of mass [m]")
    names = ("XX", "XY", "XZ", "YY", "YZ", "ZZ")
    group.add_argument("--inertia", type=float, nargs=6, metavar=names, help="about it [kg m^2]")


def _view(group: argparse._ArgumentGroup) -> None:
    group.add_argument("--view", action="store_true", help="in the Rerun viewer")
    group.add_argument(
        "--serve",
        nargs="?",
        const="127.0.0.1:9090",
        metavar="ADDRESS:PORT",
        help="in a browser; default: 127.0.0.1:9090, which only this machine reaches",
    )
    group.add_argument("--save", type=Path, metavar="RRD", help="as a file for the Rerun viewer")


def percent(text: str) -> float:
    """A share from per cent."""
    value = _number(text.rstrip("%")) / 100.0
    if not 0.0 < value <= 1.0:
        raise argparse.ArgumentTypeError(f"{text} is not above 0 and up to 100 per cent")
    return value


def positive(text: str) -> float:
    """A number above zero."""
    value = _number(text)
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not above 0")
    return value


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number") from None
