"""exidyn show: a planned motion as a table, a page of plots, an animation in Rerun, or in other formats."""

from argparse import Namespace
from pathlib import Path

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

from ..arguments.command import Command, Option, WrongUse, positive, print_warning, table_help
from ..arguments.options import (
    CELL,
    JSON,
    NO_COLLISION,
    PACKAGES,
    PLAN,
    output_option,
    require_file,
    robot_option,
)
from ..files.clearances import read_clearances, sources_of
from ..terminal.json_output import hand_over, json_text, print_written
from ..terminal.run_summary import plan_table


@Command(
    "Show a planned motion against the robot's limits: a table, and a page of plots.",
    (
        "exidyn show trajectory.toml",
        "exidyn show trajectory.toml --robot robot.toml --view",
        "exidyn show trajectory.toml --export csv points.csv --rate 250",
    ),
    (
        PLAN,
        robot_option("for torques, collisions and the animated arm"),
        output_option("FILE", meaning="page; default: the name of TRAJECTORY with .html"),
        JSON,
        Option(
            "--export FORMAT FILE",
            f"export as one of {', '.join(EXPORTS)}, see below; may be repeated",
            default=[],
            repeated=True,
        ),
        Option("--rate HZ", "sampling rate of exports", positive),
        PACKAGES,
        NO_COLLISION,
        CELL,
        Option("--view", "show the moving arm in Rerun's viewer"),
        Option("--save FILE", "save that view as a file (.rrd)", Path),
    ),
    table_help("formats", EXPORTS),
)
def show_command(args: Namespace) -> None:
    """Print the summary; write the page and the requested exports and views."""
    if (args.view or args.save) and not args.robot:
        raise WrongUse("--view and --save draw the arm: name it with --robot")
    for name, _ in args.export:
        if name not in EXPORTS:
            raise UnknownChoice("export format", name, EXPORTS)
    _require_writable(args)
    plan = read_plan(args.plan)
    model = read_model(args.robot) if args.robot else None
    for difference in _differences(plan, model):
        print_warning(difference)
    if model:
        plan = within(plan, model.robot)
    torque = nominal_torque(plan, model) if model else None
    clearances = _clearances(args, model) if model else ()
    approaches = [clearance.worst(plan.trajectory) for clearance in clearances]
    beyond = [*violations(plan, torque), *beyond_words(approaches)]
    uses = [*limit_use(plan), *([torque.use] if torque else [])]
    table = {"exidyn_motion": 1, **plan_table(plan, uses, beyond)}
    hand_over(summary(plan, uses, beyond), json_text(table), args.json)
    page = args.output or args.plan.with_suffix(".html")
    surroundings = _around(args, plan, model, clearances, nearest_words(approaches)) if model else None
    page.write_text(plan_page(plan, beyond, torque, surroundings), encoding="utf-8")
    written = [page, *_write_exports(plan, args)]
    written += _show_moving(plan, args, model, surroundings.space) if model and surroundings else []
    print_written(*written)


def _clearances(args: Namespace, model: Model) -> tuple[Clearance, ...]:
    """Clearances of the motion without a margin, which was a matter of planning."""
    return read_clearances(
        args.robot,
        model.robot,
        cell=args.cell,
        collision=not args.no_collision,
        distance=0.0,
        packages=args.packages,
    )


def _around(
    args: Namespace, plan: Plan, model: Model, clearances: tuple[Clearance, ...], nearest: str
) -> Around:
    """Surroundings that the page draws."""
    obstacles = read_surroundings(sources_of(args.robot, args.cell)).obstacles
    return Around(space_of(plan.trajectory, model.robot, obstacles, clearances), nearest)


def _require_writable(args: Namespace) -> None:
    """Raise if any file cannot be written, before the first is."""
    outputs = {"--output": args.output, "--save": args.save}
    for option, path in [*outputs.items(), *(("--export", Path(path)) for _, path in args.export)]:
        if path is not None:
            require_file(path, option, [args.plan, *([args.robot] if args.robot else [])])


def _differences(plan: Plan, model: Model | None) -> list[str]:
    """How the file was edited, and how the robot differs from the one of the plan."""
    if model is None:
        return file_warnings(plan)
    differences = fits(plan, model)
    if plan.joints != model.robot.joints:
        raise TrajectoryError(differences[0])
    return [*file_warnings(plan, model.robot), *differences]


def _write_exports(plan: Plan, args: Namespace) -> list[Path]:
    paths = []
    for name, path in args.export:
        Path(path).write_text(EXPORTS[name](plan, args.rate), encoding="utf-8")
        paths.append(Path(path))
    return paths


def _show_moving(plan: Plan, args: Namespace, model: Model, space: Space) -> list[Path]:
    """Open or save the view, if requested: Rerun takes a second to import."""
    if not (args.view or args.save):
        return []
    from ..views.live_view import Targets
    from ..views.plan_view import plan_view
    from ..views.viewers import show

    show(plan_view(plan, model, space), Targets(view=args.view, save=args.save))
    return [args.save] if args.save else []
