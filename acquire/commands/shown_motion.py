"""exidyn excite --show: a planned motion as a table, a page of plots, a view, or in other formats."""

from argparse import Namespace

from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.robot_files.surroundings import read_surroundings
from exidyn.trajectories.clearances.clearance import Clearance, beyond_words, nearest_words
from exidyn.trajectories.errors import TrajectoryError
from exidyn.trajectories.plans.exports import EXPORTS
from exidyn.trajectories.plans.plan import Plan, file_warnings, fits, within
from exidyn.trajectories.plans.plan_check import limit_use, nominal_torque, violations
from exidyn.trajectories.plans.plan_file import read_plan
from exidyn.trajectories.plans.plan_page import Around, plan_page
from exidyn.trajectories.plans.plan_space import space_of
from exidyn.trajectories.plans.plan_summary import plan_document

from ..arguments.command import Option, WrongUse, positive, print_warning
from ..arguments.options import require_file, view_options
from ..files.clearances import read_clearances, sources_of
from ..terminal.run_summary import plan_table
from .result import Result, later

SHOW_HELP = "trajectory file (.toml); with ROBOT also torques, collisions and the animated arm"
SHOWN = (
    Option("--to FORMAT", "write its points instead of the page, see below", EXPORTS),
    Option("--rate HZ", "sampling rate of these points", positive),
    *view_options("the moving arm"),
)


def show_motion(args: Namespace) -> Result:
    """Print the summary; write the page or the points, and show the view."""
    if (args.view or args.save) and not args.robot:
        raise WrongUse("--view and --save draw the arm: give ROBOT")
    path = args.output or args.show.with_suffix(f".{args.to or 'html'}")
    for option, file in {"--output": path, "--save": args.save}.items():
        require_file(file, option, [args.show, args.robot])
    plan = read_plan(args.show)
    model = read_model(args.robot) if args.robot else None
    for difference in _differences(plan, model):
        print_warning(difference)
    torque, clearances = None, tuple[Clearance, ...]()
    if model:
        plan = within(plan, model.robot)
        torque = nominal_torque(plan, model)
        # without a margin, which was a matter of planning
        clearances = read_clearances(args, model.robot, distance=0.0)
    approaches = [clearance.worst(plan.trajectory) for clearance in clearances]
    beyond = [*violations(plan, torque), *beyond_words(approaches)]
    uses = [*limit_use(plan), *([torque.use] if torque else [])]
    around = None
    if model:
        obstacles = read_surroundings(sources_of(args.robot, args.cell)).obstacles
        space = space_of(plan.trajectory, model.robot, obstacles, clearances)
        around = Around(space, nearest_words(approaches))
    content = EXPORTS[args.to](plan, args.rate) if args.to else plan_page(plan, beyond, torque, around)
    path.write_text(content, encoding="utf-8")
    table = {"exidyn_motion": 1, **plan_table(plan, uses, beyond)}
    view = later("plan_view", plan, model, around.space) if model and around else None
    return Result(plan_document(plan, uses, beyond), table, [path], view=view)


def _differences(plan: Plan, model: Model | None) -> list[str]:
    """How the file was edited, and how the robot differs from the one of the plan."""
    if model is None:
        return file_warnings(plan)
    differences = fits(plan, model)
    if plan.joints != model.robot.joints:
        raise TrajectoryError(differences[0])
    return [*file_warnings(plan, model.robot), *differences]
