"""exidyn show: a planned motion in words, as a page of plots, moving in Rerun, or in other formats."""

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
    require_file,
    require_json,
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
        robot_option("for torques, collisions and the moving arm"),
        Option("--output -o --page FILE", "the page; default: as TRAJECTORY, but ending in .html", Path),
        JSON,
        Option(
            "--export FORMAT FILE",
            f"write it as one of {', '.join(EXPORTS)}, see below; may be given several times",
            default=[],
            repeated=True,
        ),
        Option("--rate HZ", "points a second of exports", positive),
        PACKAGES,
        NO_COLLISION,
        CELL,
        Option("--view", "show it in Rerun's viewer, the arm moving"),
        Option("--save --rerun FILE", "save that view as a file (.rrd)", Path),
    ),
    table_help("formats", EXPORTS),
)
def show_command(given: Namespace) -> None:
    """Print, write the page and what else is asked for."""
    if (given.view or given.save) and not given.robot:
        raise WrongUse("--view and --save draw the arm: name it with --robot")
    for name, _ in given.export:
        if name not in EXPORTS:
            raise UnknownChoice("export format", name, EXPORTS)
    _require_places(given)
    plan = read_plan(given.plan)
    model = read_model(given.robot) if given.robot else None
    for difference in _differences(plan, model):
        print_warning(difference)
    if model:
        plan = within(plan, model.robot)
    torque = nominal_torque(plan, model) if model else None
    clearances = _clearances(given, model) if model else ()
    approaches = [clearance.worst(plan.trajectory) for clearance in clearances]
    beyond = [*violations(plan, torque), *beyond_words(approaches)]
    uses = [*limit_use(plan), *([torque.use] if torque else [])]
    table = {"exidyn_motion": 1, **plan_table(plan, uses, beyond)}
    hand_over(summary(plan, uses, beyond), json_text(table), given.json)
    page = given.output or given.plan.with_suffix(".html")
    around = _around(given, plan, model, clearances, nearest_words(approaches)) if model else None
    page.write_text(plan_page(plan, beyond, torque, around), encoding="utf-8")
    written = [page, *_write_exports(plan, given)]
    written += _show_moving(plan, given, model, around.space) if model and around else []
    print_written(*written)


def _clearances(given: Namespace, model: Model) -> tuple[Clearance, ...]:
    """What the motion must not touch: how far it should keep from it was said when it was planned."""
    return read_clearances(
        given.robot,
        model.robot,
        cell=given.region,
        collision=not given.no_collision,
        distance=0.0,
        packages=given.packages,
    )


def _around(
    given: Namespace, plan: Plan, model: Model, clearances: tuple[Clearance, ...], nearest: str
) -> Around:
    """What the page draws around the motion."""
    obstacles = read_surroundings(sources_of(given.robot, given.region)).obstacles
    return Around(space_of(plan.trajectory, model.robot, obstacles, clearances), nearest)


def _require_places(given: Namespace) -> None:
    """Make sure that all can be written before anything is."""
    require_json(given.json)
    places = {"--output": given.output, "--save": given.save}
    for option, path in [*places.items(), *(("--export", Path(path)) for _, path in given.export)]:
        if path is not None:
            require_file(path, option, [given.plan, *([given.robot] if given.robot else [])])


def _differences(plan: Plan, model: Model | None) -> list[str]:
    """How the file was edited, and how the robot at hand differs from the one planned for."""
    if model is None:
        return file_warnings(plan)
    different = fits(plan, model)
    if plan.joints != model.robot.joints:
        raise TrajectoryError(different[0])
    return [*file_warnings(plan, model.robot), *different]


def _write_exports(plan: Plan, given: Namespace) -> list[Path]:
    paths = []
    for name, path in given.export:
        Path(path).write_text(EXPORTS[name](plan, given.rate), encoding="utf-8")
        paths.append(Path(path))
    return paths


def _show_moving(plan: Plan, given: Namespace, model: Model, space: Space) -> list[Path]:
    """Open or save the view; Rerun takes a second to import, so only then."""
    if not (given.view or given.save):
        return []
    from ..views.live_view import Targets
    from ..views.plan_view import plan_view
    from ..views.viewers import show

    show(plan_view(plan, model, space), Targets(view=given.view, save=given.save))
    return [given.save] if given.save else []
