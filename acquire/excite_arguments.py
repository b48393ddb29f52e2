"""What `exidyn excite` is asked on the command line."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from exidyn.identify.effects import EFFECTS
from exidyn.identify.robot_file import builtin_names
from exidyn.trajectories.kinds import KINDS
from exidyn.trajectories.search.criteria import CRITERIA

OPTIMISED = "best"
"""Name of the kind of run that is searched for; the others are made by rule."""
IDENTIFY_ONLY = ("shapes", "payload", "focus", "after")
"""Options about what to identify, which another kind of run, or one to tell models apart, does not ask."""
EXAMPLES = """examples:
  exidyn excite robot.toml
  exidyn excite robot.toml --payload 175 --com 0 0 0.2     a pair of runs, for the drive gains
  exidyn excite robot.toml --after exidyn-fit/fit.json     where the last fit knows least
  exidyn excite robot.toml --against rival.toml            to tell two models of one arm apart
  exidyn excite robot.toml --kind sweeps --joints joint2   constant velocities, for the friction curve
  exidyn excite kuka.toml --start 0 -90 90 0 45 0 --degrees --window 30"""


def excite_options(arguments: Sequence[str]) -> argparse.Namespace:
    """What is asked; ends with a sentence where options do not go together."""
    parser = excite_parser()
    given = parser.parse_args(arguments)
    asked = [f"--kind {given.kind}"] if given.kind != OPTIMISED else []
    asked += ["--against"] if given.against else []
    useless = [f"--{name}" for name in IDENTIFY_ONLY if getattr(given, name) not in (None, [])]
    if len(asked) > 1 or asked and useless:
        parser.error(f"{' and '.join([*asked, *useless][:2])} do not go together")
    if given.joints and given.kind == OPTIMISED:
        parser.error(f"--joints is for other kinds of run than '{OPTIMISED}', in which all joints move")
    return given


def excite_parser() -> argparse.ArgumentParser:
    """All options of the command, in groups."""
    parser = argparse.ArgumentParser(
        prog="exidyn excite",
        description="Find the trajectory that identifies a robot best within its limits. "
        "Ctrl-C keeps the best so far.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "robot", metavar="ROBOT", help=f"robot.toml or .urdf, or built in: {', '.join(builtin_names())}"
    )
    parser.add_argument("-o", "--output", type=Path, default=Path("trajectory.toml"), metavar="FILE")
    _add_goal(parser)
    _add_motion(parser)
    _add_limits(parser)
    search = parser.add_argument_group("search")
    search.add_argument("--seconds", type=float, default=60.0, help="to search; default: %(default)g")
    search.add_argument("--starts", type=int, default=4, help="random starts; default: %(default)d")
    search.add_argument("--seed", type=int, default=0, help="of the first start; default: %(default)d")
    return parser


def _add_goal(parser: argparse.ArgumentParser) -> None:
    goal = parser.add_argument_group("what it is for")
    goal.add_argument(
        "--criterion",
        choices=CRITERIA,
        default="condition",
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
        "--payload",
        type=float,
        metavar="KG",
        help="plan a pair, unloaded and with this mass, for the drive gains",
    )
    goal.add_argument(
        "--com", type=float, nargs=3, metavar=("X", "Y", "Z"), help="its centre from the flange [m]"
    )
    goal.add_argument(
        "--focus", nargs="+", default=[], metavar="NAME", help="base parameters that alone matter: gain Kr K0"
    )
    goal.add_argument("--after", type=Path, metavar="FIT", help="fit.json of earlier runs, to add to")
    goal.add_argument("--against", metavar="ROBOT", help="another model of the same arm, to be told from it")
    goal.add_argument("--trajectories", type=int, default=1, metavar="K", help="plan so many together")


def _add_motion(parser: argparse.ArgumentParser) -> None:
    motion = parser.add_argument_group("motion")
    motion.add_argument(
        "--kind",
        choices=(OPTIMISED, *KINDS),
        default=OPTIMISED,
        help="; ".join(f"{name}: {(kind.__doc__ or '').rstrip('.')}" for name, kind in KINDS.items())
        + "; default: %(default)s",
    )
    motion.add_argument("--joints", nargs="+", metavar="JOINT", help="for the other kinds; default: all")
    motion.add_argument(
        "--length", type=float, default=40.0, metavar="S", help="seconds; default: %(default)g"
    )
    motion.add_argument("--period", type=float, metavar="S", help="base period; default: several are tried")
    motion.add_argument("--harmonics", type=int, default=5, help="of each joint; default: %(default)d")
    motion.add_argument(
        "--tick", type=float, default=0.002, metavar="S", help="controller cycle; default: %(default)g"
    )
    motion.add_argument("--start", type=float, nargs="+", metavar="Q", help="pose to begin and end at [rad]")


def _add_limits(parser: argparse.ArgumentParser) -> None:
    limits = parser.add_argument_group("limits, beyond the robot's own")
    limits.add_argument("--degrees", action="store_true", help="--start and --window are in degrees")
    limits.add_argument(
        "--window",
        type=float,
        nargs="+",
        metavar="Q",
        help="RSI's AXISCORR: most from the start pose, one or n [rad]",
    )
    limits.add_argument(
        "--margin", type=float, default=0.05, help="share kept off velocity … torque; default: %(default)g"
    )
    limits.add_argument("--region", type=Path, metavar="FILE", help="TOML with [[region]] rows, see docs")
    limits.add_argument(
        "--collision-distance",
        type=float,
        default=0.02,
        metavar="M",
        help="between bodies; default: %(default)g",
    )
    limits.add_argument("--no-collision", action="store_true", help="do not look at the URDF's geometry")
    limits.add_argument(
        "--packages", type=Path, nargs="+", default=[], metavar="DIR", help="where meshes are"
    )
