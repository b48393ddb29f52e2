"""exidyn excite: a robot in; the trajectory that identifies it best out, or another kind of run."""

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from exidyn.identification.effects import EFFECTS, known_parameters
from exidyn.identification.errors import RobotError
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.fit.fit_warnings import WORST
from exidyn.identification.model import Model
from exidyn.identification.progress import StageText
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.text_table import paragraph
from exidyn.trajectories.discrimination.discriminate import Discriminate
from exidyn.trajectories.discrimination.distinction import distinguish, sentences
from exidyn.trajectories.errors import BadLimits
from exidyn.trajectories.kinds.by_rule import KINDS, by_rule
from exidyn.trajectories.limits.usable_limits import Margins, usable
from exidyn.trajectories.planning.goals import two_models, with_bodies
from exidyn.trajectories.planning.planner import plan
from exidyn.trajectories.planning.wishes import Wishes, rows_of
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_check import Use, limit_use, nominal_torque, violations
from exidyn.trajectories.plans.plan_file import write_plan
from exidyn.trajectories.plans.plan_summary import summary
from exidyn.trajectories.search.criteria import CRITERIA

from ..arguments.command import Command, Group, Option, WrongUse, any_number, integer, positive
from ..arguments.options import (
    CELL,
    JSON,
    NO_COLLISION,
    PACKAGES,
    ROBOT_FILES,
    output_option,
    require_file,
    require_json,
)
from ..files.clearances import read_clearances
from ..terminal.json_output import hand_over, json_text
from ..terminal.run_summary import plan_table
from ..terminal.stopwatch import Progress, Stopwatch

OPTIMISED = "best"
"""Name of the kind of run that is searched for; the others are made by rule."""
IDENTIFY_ONLY = ("shapes", "mass", "focus", "after")
"""Options about what to identify, which another kind of run, or one to distinguish models, does not need."""
STAGES = {"make": 0.01, "torque": 0.6, "check": 0.39}
"""Stages of a run made by rule, and their shares of the time."""
GOAL = (
    Option(
        "--criterion NAME",
        "what is made small: condition number of the scaled regressor, volume of the confidence "
        "ellipsoid (D), average (A) or worst (E) relative deviation; default: condition, with --after worst, "
        "with --mass the volume of the drive gains alone",
        CRITERIA,
    ),
    Option(
        "--shapes EFFECT...",
        "effects whose shapes are unknown too, such as stribeck_friction",
        [key for key, effect in EFFECTS.items() if effect.shapes()],
        [],
    ),
    Option(
        "--mass --payload KG...",
        "plan a run unloaded and one with each mass, all of one motion, for the drive gains",
        any_number,
        [],
    ),
    Option(
        "--com X Y Z", "its centre from the flange [m]; once for each mass", any_number, [], repeated=True
    ),
    Option(
        "--focus --for NAME...",
        "what alone matters: gain Kr, or in words 'K_r, friction of joint 2'",
        str,
        [],
    ),
    Option("--after --from FIT", "fit.json of earlier runs, to add to", Path),
    Option("--against ROBOT", "another model of the same arm, to be distinguished from it"),
    Option("--trajectories N", "plan so many together; default: 1", integer, 1),
)
MOTION = (
    Option(
        "--kind KIND",
        f"{OPTIMISED}: Found by search; "
        + "; ".join(f"{name}: {(kind.__doc__ or '').rstrip('.')}" for name, kind in KINDS.items()),
        (OPTIMISED, *KINDS),
        OPTIMISED,
    ),
    Option("--joints JOINT...", "for the other kinds; default: all"),
    Option("--length S", "seconds", any_number, Wishes.seconds),
    Option("--period S", "base period; default: several are tried", any_number),
    Option("--harmonics N", "of each joint", integer, Wishes.harmonics),
    Option("--tick S", "controller cycle", any_number, Wishes.tick),
    Option("--start Q...", "pose to begin and end at [rad]", any_number),
)
LIMITS = (
    Option("--degrees", "--start and --window are in degrees"),
    Option("--window Q...", "RSI's AXISCORR: most from the start pose, one or n [rad]", any_number),
    Option("--margin SHARE", "share kept off velocity … torque", any_number, 0.05),
    Option(
        "--sure SHARE",
        "share of possible arms (priors, fit) that must keep to the torque limits; 0: the nominal arm",
        any_number,
        Wishes.sure,
    ),
    CELL,
    Option("--collision-distance M", "between bodies", positive, 0.02),
    NO_COLLISION,
    PACKAGES,
)
"""Those that a study keeps to as well."""


@Command(
    "Find the trajectory that identifies a robot best within its limits. Ctrl-C keeps the best so far.",
    (
        "exidyn excite robot.toml",
        "exidyn excite robot.toml --mass 175 --com 0.1 0 0.2      # a pair of runs, for the drive gains",
        "exidyn excite robot.toml --kind sweeps --joints joint2   # constant velocities, for friction",
    ),
    (
        Option("robot ROBOT", ROBOT_FILES),
        output_option("FILE", Path("trajectory.toml")),
        JSON,
        Group("what it is for", GOAL),
        Group("motion", MOTION),
        Group("limits, beyond the robot's own", LIMITS),
        Group(
            "search",
            (
                Option("--search --seconds S", "seconds", any_number, 60.0),
                Option("--starts N", "random starts", integer, 4),
                Option("--seed N", "of the first start", integer, 0),
            ),
        ),
    ),
)
def excite_command(given: Namespace) -> None:
    """Plan, print, write."""
    _require_together(given)
    read = [given.robot, *(one for one in (given.against, given.after, given.region) if one)]
    require_file(given.output, "--output", read)
    require_json(given.json)
    model = read_model(given.robot)
    searched = given.kind == OPTIMISED
    with Stopwatch({} if searched else STAGES, given.search if searched else 0.0) as progress:
        plans, distinguished = _planned(given, model, progress)
        loaded, _ = with_bodies(model, _bodies(given))
        checked = [_checked(one, loaded, progress) for one in plans]
    pages, tables = [], []
    for one, (uses, beyond), path in zip(plans, checked, _paths(given.output, len(plans)), strict=True):
        write_plan(one, path)
        pages += [summary(one, uses, beyond), *_poor(one), f"written: {path}; exidyn show {path} draws it"]
        tables.append(plan_table(one, uses, beyond) | {"written": str(path)})
    table = {"exidyn_plan": 1, "motions": tables, "distinguished": distinguished}
    hand_over("\n".join([*_wrapped(distinguished), *pages]), json_text(table), given.json)


def _checked(one: Plan, model: Model, progress: Progress) -> tuple[list[Use], list[str]]:
    """How much of the limits a motion uses, and what it does beyond them, a sentence each."""
    progress(StageText("torque", f"compute the torque of its {one.trajectory.duration:.0f} s"))
    torque = nominal_torque(one, model)
    progress(StageText("check", "check it against all limits, and stops from every tick"))
    return [*limit_use(one), torque.use], violations(one, torque)


def _require_together(given: Namespace) -> None:
    """Make sure that the options go together."""
    asked = [f"--kind {given.kind}"] if given.kind != OPTIMISED else []
    asked += ["--against"] if given.against else []
    useless = [f"--{name}" for name in IDENTIFY_ONLY if getattr(given, name) not in (None, [])]
    if len(asked) > 1 or asked and useless:
        raise WrongUse(f"{' and '.join([*asked, *useless][:2])} do not go together")
    if given.joints and given.kind == OPTIMISED:
        raise WrongUse(f"--joints is for other kinds of run than '{OPTIMISED}', in which all joints move")


def _planned(given: Namespace, model: Model, progress: Progress) -> tuple[list[Plan], list[str]]:
    """Motions, and what is to be said of them all."""
    wishes = wishes_of(given, model, progress)
    if given.kind != OPTIMISED:
        progress(StageText("make", f"make {given.kind}"))
        joints = [model.robot.index(joint) for joint in given.joints or ()]
        return [by_rule(given.kind, model, wishes, joints, progress)], []
    if given.against:
        return _against(given, model, wishes, progress)
    return _search(given, model, wishes, progress), []


def _wrapped(sentences: Sequence[str]) -> list[str]:
    return [line for one in sentences for line in paragraph(one)]


def _poor(one: Plan) -> list[str]:
    """A warning where the best motion found is poor."""
    condition = one.reached if one.criterion == "condition" else float(one.details.get("condition", 1.0))
    if not condition < WORST:
        warning = (
            f"the best motion found is poor: condition number {condition:.3g}, from {WORST:g} on some "
            "combination of parameters is hardly seen. Try a wider range or window, a longer --period, more "
            "--search, or a model with fewer unknowns"
        )
        return paragraph(warning, " " * 11, "  WARNING: ")
    return []


def _search(
    given: Namespace,
    model: Model,
    wishes: Wishes,
    progress: Progress,
    goal: Discriminate | None = None,
) -> list[Plan]:
    return plan(
        model,
        wishes,
        goal=goal,
        starts=given.starts,
        seed=given.seed,
        seconds=given.search,
        progress=progress,
    )


def _against(
    given: Namespace, model: Model, wishes: Wishes, progress: Progress
) -> tuple[list[Plan], list[str]]:
    """The run that distinguishes two models, and how well in sentences."""
    rival = read_model(given.against)
    names = [model.robot.name, rival.robot.name]
    if names[0] == names[1]:
        names = [str(given.robot), str(given.against)]
    limits, _ = usable(model.robot, wishes.margins, wishes.window, wishes.start)
    goal = two_models((model, rival), names, limits, rows_of(wishes))
    plans = _search(given, model, wishes, progress, goal)
    lines = []
    for one in plans:
        motion = one.trajectory.every(0.01).motion()
        lines += sentences(distinguish(goal, motion, limits, one.trajectory.duration))
    return plans, lines


def wishes_of(given: Namespace, model: Model, progress: Progress) -> Wishes:
    """What the command line asks of a motion."""
    turn = np.where(model.robot.revolute & given.degrees, np.pi / 180.0, 1.0)
    start = _joint_values(given.start, model, "--start")
    window = _joint_values(given.window, model, "--window")
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
        clearances=read_clearances(
            given.robot,
            model.robot,
            cell=given.region,
            collision=not given.no_collision,
            distance=given.collision_distance,
            packages=given.packages,
            say=progress,
        ),
        shapes=given.shapes,
        focus=given.focus,
        sure=given.sure,
        bodies=_bodies(given),
        fit=None if given.after is None else read_fit(given.after),
    )


def _bodies(given: Namespace) -> list[tuple[tuple[str, float], ...]]:
    """What is known of each body."""
    centres = given.com or [None] * len(given.mass)
    if len(centres) != len(given.mass):
        raise RobotError(
            f"{len(given.mass)} masses and {len(centres)} centres: --com is the centre of a payload's mass, "
            "given with --mass; give one for each mass, or none"
        )
    return [known_parameters(mass, centre) for mass, centre in zip(given.mass, centres, strict=True)]


def _joint_values(values: Sequence[float] | None, model: Model, option: str) -> np.ndarray | None:
    """One value a joint; a single one stands for all."""
    if values is None:
        return None
    if len(values) not in (1, model.robot.dof):
        raise BadLimits(f"{option}: {len(values)} values; give 1 or {model.robot.dof}, one a joint")
    return np.broadcast_to(np.array(values), (model.robot.dof,)).copy()


def _paths(output: Path, count: int) -> list[Path]:
    """The file of each trajectory: the one named, or with numbers from 1."""
    if count == 1:
        return [output]
    return [output.with_stem(f"{output.stem}-{number}") for number in range(1, count + 1)]
