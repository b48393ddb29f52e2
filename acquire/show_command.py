"""exidyn show: a planned motion in words, as a page of plots, moving in Rerun, or in other formats."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from exidyn.identify.model import Model
from exidyn.identify.robot_file import builtin_names, read_model
from exidyn.trajectories.errors import TrajectoryError, UnknownChoice
from exidyn.trajectories.plans.exports import EXPORTS
from exidyn.trajectories.plans.plan import Plan, fits
from exidyn.trajectories.plans.plan_check import Torque, believed_torque, violations
from exidyn.trajectories.plans.plan_file import read_plan
from exidyn.trajectories.plans.plan_page import plan_page
from exidyn.trajectories.plans.plan_summary import summary
from exidyn.trajectories.plans.plan_use import limit_use

from .table_help import table_help

EXAMPLE = "example: exidyn show plan.toml --robot kr270 --view --export csv plan.csv"


def main(arguments: Sequence[str]) -> int:
    """Print, write the page and what else is asked for."""
    parser = _parser()
    given = parser.parse_args(arguments)
    if (given.view or given.rerun) and not given.robot:
        parser.error("--view and --rerun draw the arm: say which with --robot")
    for name, _ in given.export:
        if name not in EXPORTS:
            raise UnknownChoice("export format", name, EXPORTS)
    plan = read_plan(given.plan)
    model = read_model(given.robot) if given.robot else None
    for difference in _differences(plan, model):
        print(f"exidyn: warning: {difference}", file=sys.stderr)
    torque = believed_torque(plan, model) if model else None
    beyond = violations(plan, torque)
    uses = [*limit_use(plan), *([torque.use] if torque else [])]
    print(summary(plan, uses, beyond), flush=True)
    written = [_write_page(plan, given, beyond, torque), *_write_exports(plan, given)]
    written += _show_moving(plan, given, model) if model else []
    print("written: " + ", ".join(map(str, written)), file=sys.stderr)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="exidyn show",
        description="Show a planned motion against the robot's limits: a table, and a page of plots.",
        epilog=f"{EXAMPLE}\n\n{table_help('formats', EXPORTS)}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("plan", type=Path, metavar="FILE", help="trajectory file (.toml)")
    parser.add_argument(
        "--robot",
        metavar="ROBOT",
        help="for torques and the moving arm: robot.toml or .urdf, or built in: "
        + ", ".join(builtin_names()),
    )
    parser.add_argument("--page", type=Path, metavar="HTML", help="default: FILE, but ending in .html")
    parser.add_argument(
        "--export",
        nargs=2,
        action="append",
        default=[],
        metavar=("FORMAT", "OUT"),
        help=f"write it as one of {', '.join(EXPORTS)}, see below; may be given several times",
    )
    parser.add_argument("--rate", type=_rate, metavar="HZ", help="points a second of exports")
    parser.add_argument("--view", action="store_true", help="show it in the Rerun viewer, the arm moving")
    parser.add_argument("--rerun", type=Path, metavar="RRD", help="save that view as a file")
    return parser


def _rate(text: str) -> float:
    value = float(text)
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} must be above 0")
    return value


def _differences(plan: Plan, model: Model | None) -> list[str]:
    """How the robot at hand differs from the one planned for.

    Raises:
        TrajectoryError: It has other joints, so that nothing of it can be shown.
    """
    if model is None:
        return []
    different = fits(plan, model)
    if plan.joints != model.robot.joints:
        raise TrajectoryError(different[0])
    return different


def _write_page(plan: Plan, given: argparse.Namespace, beyond: list[str], torque: Torque | None) -> Path:
    path = given.page or given.plan.with_suffix(".html")
    path.write_text(plan_page(plan, beyond, torque), encoding="utf-8")
    return path


def _write_exports(plan: Plan, given: argparse.Namespace) -> list[Path]:
    paths = []
    for name, path in given.export:
        Path(path).write_text(EXPORTS[name](plan, given.rate), encoding="utf-8")
        paths.append(Path(path))
    return paths


def _show_moving(plan: Plan, given: argparse.Namespace, model: Model) -> list[Path]:
    """Open or save the view; Rerun takes a second to import, so only then."""
    if not (given.view or given.rerun):
        return []
    from exidyn.trajectories.plans.view import open_rerun, save_rerun

    if given.rerun:
        save_rerun(plan, model, given.rerun)
    if given.view:
        open_rerun(plan, model)
    return [given.rerun] if given.rerun else []
