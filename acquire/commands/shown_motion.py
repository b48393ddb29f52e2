"""exidyn excite --show: a planned motion as a table, a page of plots, a view, or in other formats."""

from argparse import Namespace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.robot_files.surroundings import read_surroundings
from exidyn.trajectories.clearances.clearance import Clearance, beyond_words, nearest_words
from exidyn.trajectories.errors import TrajectoryError, UnknownChoice
from exidyn.trajectories.plans.exports import EXPORTS
from exidyn.trajectories.plans.plan import Plan, fits
from exidyn.trajectories.plans.plan_check import limit_use, nominal_torque, violations
from exidyn.trajectories.plans.plan_file import read_plan
from exidyn.trajectories.plans.plan_limits import file_warnings, within
from exidyn.trajectories.plans.plan_page import Around, plan_page
from exidyn.trajectories.plans.plan_space import Space, space_of
from exidyn.trajectories.plans.plan_summary import summary

from ..arguments.command import Option, WrongUse, positive, print_warning
from ..arguments.options import require_file, view_options
from ..files.clearances import read_clearances, sources_of
from ..terminal.run_summary import plan_table
from .result import Result

if TYPE_CHECKING:
    from ..views.viewers import View

SHOW_HELP = "trajectory file (.toml); with ROBOT also torques, collisions and the animated arm"
SHOWN = (
    Option(
        "--export FORMAT FILE",
        f"export as one of {', '.join(EXPORTS)}, see below; may be repeated",
        default=[],
        repeated=True,
    ),
    Option("--rate HZ", "sampling rate of exports", positive),
    *view_options("the moving arm"),
)


def show_motion(args: Namespace) -> Result:
    """Print the summary; write the page and the requested exports and views."""
    if (args.view or args.save) and not args.robot:
        raise WrongUse("--view and --save draw the arm: give ROBOT")
    for name, _ in args.export:
        if name not in EXPORTS:
            raise UnknownChoice("export format", name, EXPORTS)
    _require_writable(args)
    plan = read_plan(args.show)
    model = read_model(args.robot) if args.robot else None
    for difference in _differences(plan, model):
        print_warning(difference)
    torque, clearances = None, tuple[Clearance, ...]()
    if model:
        plan = within(plan, model.robot)
        torque = nominal_torque(plan, model)
        # without a margin, which was a matter of planning
        clearances = read_clearances(
            args.robot, model.robot, cell=args.cell, collision=not args.no_collision, distance=0.0
        )
    approaches = [clearance.worst(plan.trajectory) for clearance in clearances]
    beyond = [*violations(plan, torque), *beyond_words(approaches)]
    uses = [*limit_use(plan), *([torque.use] if torque else [])]
    around = None
    if model:
        obstacles = read_surroundings(sources_of(args.robot, args.cell)).obstacles
        space = space_of(plan.trajectory, model.robot, obstacles, clearances)
        around = Around(space, nearest_words(approaches))
    page = args.output or args.show.with_suffix(".html")
    page.write_text(plan_page(plan, beyond, torque, around), encoding="utf-8")
    for name, path in args.export:
        Path(path).write_text(EXPORTS[name](plan, args.rate), encoding="utf-8")
    written = [page, *(Path(path) for _, path in args.export)]
    table = {"exidyn_motion": 1, **plan_table(plan, uses, beyond)}
    view = partial(_view, plan, model, around.space) if model and around else None
    return Result(summary(plan, uses, beyond), table, written, view)


def _require_writable(args: Namespace) -> None:
    """Raise if any file cannot be written, before the first is."""
    outputs = {"--output": args.output, "--save": args.save}
    for option, path in [*outputs.items(), *(("--export", Path(path)) for _, path in args.export)]:
        if path is not None:
            require_file(path, option, [args.show, *([args.robot] if args.robot else [])])


def _differences(plan: Plan, model: Model | None) -> list[str]:
    """How the file was edited, and how the robot differs from the one of the plan."""
    if model is None:
        return file_warnings(plan)
    differences = fits(plan, model)
    if plan.joints != model.robot.joints:
        raise TrajectoryError(differences[0])
    return [*file_warnings(plan, model.robot), *differences]


def _view(plan: Plan, model: Model, space: Space) -> "View":
    from ..views.plan_view import plan_view  # Rerun takes a second to import

    return plan_view(plan, model, space)
