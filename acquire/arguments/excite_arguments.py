"""What `exidyn excite` is asked on the command line."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from exidyn.identify.effects import EFFECTS
from exidyn.identify.robot_files.robot_file import builtin_names
from exidyn.trajectories.kinds.by_rule import KINDS
from exidyn.trajectories.search.criteria import CRITERIA

from .common import any_number, command_parser, integer, positive
from .outputs import add_json, add_output

OPTIMISED = "best"
"""Name of the kind of run that is searched for; the others are made by rule."""
IDENTIFY_ONLY = ("shapes", "mass", "focus", "after")
"""Options about what to identify, which another kind of run, or one to distinguish models, does not need."""
EXAMPLES = (
    "exidyn excite robot.toml",
    "exidyn excite robot.toml --mass 175 --com 0.1 0 0.2      # a pair of runs, for the drive gains",
    "exidyn excite robot.toml --kind sweeps --joints joint2   # constant velocities, for the friction curve",
)


def excite_options(arguments: Sequence[str]) -> argparse.Namespace:
    """What is asked; ends with a sentence where options do not go together."""
    options = parser()
    given = options.parse_args(arguments)
    asked = [f"--kind {given.kind}"] if given.kind != OPTIMISED else []
    asked += ["--against"] if given.against else []
    useless = [f"--{name}" for name in IDENTIFY_ONLY if getattr(given, name) not in (None, [])]
    if len(asked) > 1 or asked and useless:
        options.error(f"{' and '.join([*asked, *useless][:2])} do not go together")
    if given.joints and given.kind == OPTIMISED:
        options.error(f"--joints is for other kinds of run than '{OPTIMISED}', in which all joints move")
    return given


def parser() -> argparse.ArgumentParser:
    """All options of the command, in groups."""
    found = command_parser(
        "excite",
        "Find the trajectory that identifies a robot best within its limits. Ctrl-C keeps the best so far.",
        EXAMPLES,
    )
    found.add_argument(
        "robot",
        metavar="ROBOT",
        help=f"robot.toml, .urdf, .xacro, or built in: {', '.join(builtin_names())}",
    )
    add_output(found, "FILE", Path("trajectory.toml"))
    add_json(found)
    _add_goal(found)
    _add_motion(found)
    add_limits(found)
    search = found.add_argument_group("search")
    search.add_argument(
        "--search",
        "--seconds",
        type=any_number,
        default=60.0,
        metavar="S",
        help="seconds; default: %(default)g",
    )
    search.add_argument(
        "--starts", type=integer, default=4, metavar="N", help="random starts; default: %(default)d"
    )
    search.add_argument(
        "--seed", type=integer, default=0, metavar="N", help="of the first start; default: %(default)d"
    )
    return found


def _add_goal(parser: argparse.ArgumentParser) -> None:
    goal = parser.add_argument_group("what it is for")
    goal.add_argument(
        "--criterion",
        choices=CRITERIA,
        default="condition",
        metavar="NAME",
        help="what is made small: condition number of the scaled regressor, volume of the confidence "
        "ellipsoid (D), average (A) or worst (E) relative deviation; default: %(default)s",
    )
    goal.add_argument(
        "--shapes",
        nargs="+",
        default=[],
        choices=[key for key, effect in EFFECTS.items() if effect.shapes()],
        metavar="EFFECT",
        help="effects whose shapes are unknown too, such as stribeck_friction",
    )
    goal.add_argument(
        "--mass",
        "--payload",
        type=any_number,
        metavar="KG",
        help="plan a pair, unloaded and with this mass, for the drive gains",
    )
    goal.add_argument(
        "--com", type=any_number, nargs=3, metavar=("X", "Y", "Z"), help="its centre from the flange [m]"
    )
    goal.add_argument(
        "--focus", nargs="+", default=[], metavar="NAME", help="base parameters that alone matter: gain Kr K0"
    )
    goal.add_argument("--after", type=Path, metavar="FIT", help="fit.json of earlier runs, to add to")
    goal.add_argument(
        "--against", metavar="ROBOT", help="another model of the same arm, to be distinguished from it"
    )
    goal.add_argument("--trajectories", type=integer, default=1, metavar="N", help="plan so many together")


def _add_motion(parser: argparse.ArgumentParser) -> None:
    motion = parser.add_argument_group("motion")
    motion.add_argument(
        "--kind",
        choices=(OPTIMISED, *KINDS),
        default=OPTIMISED,
        metavar="KIND",
        help=f"{OPTIMISED}: Found by search; "
        + "; ".join(f"{name}: {(kind.__doc__ or '').rstrip('.')}" for name, kind in KINDS.items())
        + "; default: %(default)s",
    )
    motion.add_argument("--joints", nargs="+", metavar="JOINT", help="for the other kinds; default: all")
    motion.add_argument(
        "--length", type=any_number, default=40.0, metavar="S", help="seconds; default: %(default)g"
    )
    motion.add_argument(
        "--period", type=any_number, metavar="S", help="base period; default: several are tried"
    )
    motion.add_argument(
        "--harmonics", type=integer, default=5, metavar="N", help="of each joint; default: %(default)d"
    )
    motion.add_argument(
        "--tick", type=any_number, default=0.002, metavar="S", help="controller cycle; default: %(default)g"
    )
    motion.add_argument(
        "--start", type=any_number, nargs="+", metavar="Q", help="pose to begin and end at [rad]"
    )


def add_limits(parser: argparse.ArgumentParser) -> None:
    """Add --margin, --start, --window, --region and what is known of bodies."""
    limits = parser.add_argument_group("limits, beyond the robot's own")
    limits.add_argument("--degrees", action="store_true", help="--start and --window are in degrees")
    limits.add_argument(
        "--window",
        type=any_number,
        nargs="+",
        metavar="Q",
        help="RSI's AXISCORR: most from the start pose, one or n [rad]",
    )
    limits.add_argument(
        "--margin",
        type=any_number,
        default=0.05,
        metavar="SHARE",
        help="share kept off velocity … torque; default: %(default)g",
    )
    limits.add_argument("--region", type=Path, metavar="FILE", help="TOML with [[region]] rows, see docs")
    limits.add_argument(
        "--collision-distance",
        type=positive,
        default=0.02,
        metavar="M",
        help="between bodies; default: %(default)g",
    )
    limits.add_argument("--no-collision", action="store_true", help="do not look at the URDF's geometry")
    limits.add_argument(
        "--packages",
        type=Path,
        nargs="+",
        action="extend",
        default=[],
        metavar="FOLDER",
        help="where meshes are",
    )
