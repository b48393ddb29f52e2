"""exidyn excite: a robot in; the trajectory that identifies it best out."""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from exidyn.identify.effects import EFFECTS, known_parameters
from exidyn.identify.errors import RobotError
from exidyn.identify.fit_file import read_fit
from exidyn.identify.geometry import read_geometry
from exidyn.identify.model import Model
from exidyn.identify.robot_file import builtin_names, read_model
from exidyn.identify.toml_fields import check_keys, parse_toml, read_text
from exidyn.trajectories.clearance import Clearance
from exidyn.trajectories.criteria import CRITERIA
from exidyn.trajectories.errors import BadLimits
from exidyn.trajectories.plan import Plan
from exidyn.trajectories.plan_check import believed_torque, violations
from exidyn.trajectories.plan_file import write_plan
from exidyn.trajectories.plan_summary import summary
from exidyn.trajectories.plan_use import limit_use
from exidyn.trajectories.planning import Wishes, plan
from exidyn.trajectories.region_rows import read_regions
from exidyn.trajectories.self_collision import SelfCollision
from exidyn.trajectories.usable_limits import Margins

from .identify_command import stopwatch

EXAMPLES = """examples:
  exidyn excite robot.toml
  exidyn excite robot.toml --payload 175 --com 0 0 0.2     a pair of runs, for the drive gains
  exidyn excite robot.toml --after exidyn-fit/fit.json     where the last fit knows least
  exidyn excite kuka.toml --start 0 -90 90 0 45 0 --degrees --window 5"""


def main(arguments: Sequence[str]) -> int:
    """Plan, print, write."""
    given = _parser().parse_args(arguments)
    model = read_model(given.robot)
    progress = stopwatch()
    plans = plan(
        model,
        _wishes(given, model, progress),
        starts=given.starts,
        seed=given.seed,
        seconds=given.seconds,
        progress=progress,
    )
    for one, path in zip(plans, _paths(given.output, len(plans)), strict=True):
        torque = believed_torque(one, model)
        print(summary(one, limit_use(one), violations(one, torque)))
        _write(one, path)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="exidyn excite",
        description="Find the trajectory that identifies a robot best within its limits. Ctrl-C keeps the best.",
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
        help="what is made small: condition number of the scaled regressor, volume of the confidence ellipsoid "
        "(D), average (A) or worst (E) relative deviation; default: %(default)s",
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
    goal.add_argument("--trajectories", type=int, default=1, metavar="K", help="plan so many together")


def _add_motion(parser: argparse.ArgumentParser) -> None:
    motion = parser.add_argument_group("motion")
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


def _wishes(given: argparse.Namespace, model: Model, progress: Callable[[str], None]) -> Wishes:
    turn = np.where(model.robot.revolute & given.degrees, np.pi / 180.0, 1.0)
    start = _joint_values(given.start, model, "--start")
    window = _joint_values(given.window, model, "--window")
    payload = None if given.payload is None else known_parameters(given.payload, given.com)
    return Wishes(
        criterion=given.criterion,
        harmonics=given.harmonics,
        period=given.period,
        seconds=given.length,
        series=given.trajectories,
        margins=replace(
            Margins(),
            velocity=given.margin,
            acceleration=given.margin,
            jerk=given.margin,
            torque=given.margin,
        ),
        window=None if window is None else turn * window,
        start=None if start is None else turn * start,
        tick=given.tick,
        clearances=_clearances(given, model, progress),
        shapes=given.shapes,
        focus=given.focus,
        payload=payload,
        fit=None if given.after is None else read_fit(given.after),
    )


def _joint_values(values: Sequence[float] | None, model: Model, option: str) -> np.ndarray | None:
    """One value a joint; a single one stands for all."""
    if values is None:
        return None
    if len(values) not in (1, model.robot.dof):
        raise BadLimits(f"{option}: {len(values)} values; give 1 or {model.robot.dof}, one a joint")
    return np.broadcast_to(np.array(values), (model.robot.dof,)).copy()


def _clearances(
    given: argparse.Namespace, model: Model, progress: Callable[[str], None]
) -> tuple[Clearance, ...]:
    """Self-collision where the robot's URDF has geometry, and the regions of the command line."""
    found: list[Clearance] = []
    geometry = None if given.no_collision else read_geometry(given.robot, given.packages)
    if geometry is not None:
        collision = SelfCollision.of(model.robot, geometry, given.collision_distance)
        progress(f"{len(collision.names)} pairs of bodies are kept {given.collision_distance:g} m apart")
        found.append(collision)
    elif not given.no_collision:
        progress("the robot has no collision geometry, so self-collision is not looked at")
    if given.region:
        table = parse_toml(read_text(given.region), str(given.region))
        check_keys(table, ("region",), str(given.region))
        if "region" not in table:
            raise RobotError(f"{given.region}: no [[region]] row in it")
        found += read_regions(table["region"], model.robot)
    return tuple(found)


def _paths(output: Path, count: int) -> list[Path]:
    """The file of each trajectory: the one named, or with numbers from 1."""
    if count == 1:
        return [output]
    return [output.with_stem(f"{output.stem}-{number}") for number in range(1, count + 1)]


def _write(one: Plan, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_plan(one, path)
    print(f"written: {path}; exidyn show {path} draws it")
