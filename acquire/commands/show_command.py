"""exidyn show: a planned motion in words, as a page of plots, moving in Rerun, or in other formats."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from exidyn.identify.model import Model
from exidyn.identify.robot_files.robot_file import read_model
from exidyn.trajectories.errors import TrajectoryError, UnknownChoice
from exidyn.trajectories.plans.exports import EXPORTS
from exidyn.trajectories.plans.plan import Plan, fits
from exidyn.trajectories.plans.plan_check import limit_use, nominal_torque, violations
from exidyn.trajectories.plans.plan_file import read_plan
from exidyn.trajectories.plans.plan_page import plan_page
from exidyn.trajectories.plans.plan_summary import summary

from ..arguments.common import add_plan, add_robot, command_parser, complaint, positive, table_help
from ..arguments.outputs import add_json, require_file, require_json
from ..terminal.json_output import hand_over, json_text, print_written
from ..terminal.run_summary import plan_table

EXAMPLES = (
    "exidyn show trajectory.toml",
    "exidyn show trajectory.toml --robot robot.toml --view",
    "exidyn show trajectory.toml --export csv points.csv --rate 250",
)


def main(arguments: Sequence[str]) -> int:
    """Print, write the page and what else is asked for."""
    options = parser()
    given = options.parse_args(arguments)
    if (given.view or given.save) and not given.robot:
        options.error("--view and --save draw the arm: name it with --robot")
    for name, _ in given.export:
        if name not in EXPORTS:
            raise UnknownChoice("export format", name, EXPORTS)
    _require_places(given)
    plan = read_plan(given.plan)
    model = read_model(given.robot) if given.robot else None
    for difference in _differences(plan, model):
        print(complaint(f"exidyn: warning: {difference}"), file=sys.stderr)
    torque = nominal_torque(plan, model) if model else None
    beyond = violations(plan, torque)
    uses = [*limit_use(plan), *([torque.use] if torque else [])]
    table = {"exidyn_motion": 1, **plan_table(plan, uses, beyond)}
    hand_over(summary(plan, uses, beyond), json_text(table), given.json)
    page = given.output or given.plan.with_suffix(".html")
    page.write_text(plan_page(plan, beyond, torque), encoding="utf-8")
    written = [page, *_write_exports(plan, given)]
    written += _show_moving(plan, given, model) if model else []
    print_written(*written)
    return 0


def parser() -> argparse.ArgumentParser:
    """What `exidyn show` takes."""
    found = command_parser(
        "show",
        "Show a planned motion against the robot's limits: a table, and a page of plots.",
        EXAMPLES,
        table_help("formats", EXPORTS),
    )
    add_plan(found)
    add_robot(found, "for torques and the moving arm")
    found.add_argument(
        "--output",
        "-o",
        "--page",
        type=Path,
        metavar="FILE",
        help="the page; default: as TRAJECTORY, but ending in .html",
    )
    add_json(found)
    found.add_argument(
        "--export",
        nargs=2,
        action="append",
        default=[],
        metavar=("FORMAT", "FILE"),
        help=f"write it as one of {', '.join(EXPORTS)}, see below; may be given several times",
    )
    found.add_argument("--rate", type=positive, metavar="HZ", help="points a second of exports")
    found.add_argument("--view", action="store_true", help="show it in Rerun's viewer, the arm moving")
    found.add_argument("--save", "--rerun", type=Path, metavar="FILE", help="save that view as a file (.rrd)")
    return found


def _require_places(given: argparse.Namespace) -> None:
    """Make sure that all can be written before anything is."""
    require_json(given.json)
    places = {"--output": given.output, "--save": given.save}
    for option, path in [*places.items(), *(("--export", Path(path)) for _, path in given.export)]:
        if path is not None:
            require_file(path, option, [given.plan, *([given.robot] if given.robot else [])])


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


def _write_exports(plan: Plan, given: argparse.Namespace) -> list[Path]:
    paths = []
    for name, path in given.export:
        Path(path).write_text(EXPORTS[name](plan, given.rate), encoding="utf-8")
        paths.append(Path(path))
    return paths


def _show_moving(plan: Plan, given: argparse.Namespace, model: Model) -> list[Path]:
    """Open or save the view; Rerun takes a second to import, so only then."""
    if not (given.view or given.save):
        return []
    from ..views.live_view import Targets
    from ..views.plan_view import plan_view
    from ..views.viewers import show

    show(plan_view(plan, model), Targets(view=given.view, save=given.save))
    return [given.save] if given.save else []
