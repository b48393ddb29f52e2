"""exidyn excite: plan the trajectory that identifies a robot best, or another kind of run, or show one."""

import shlex
from argparse import Namespace
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from exidyn.identification.effects import EFFECTS, known_parameters
from exidyn.identification.errors import RobotError
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.fit.fit_warnings import WORST
from exidyn.identification.model import Model
from exidyn.identification.progress import StageText
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.discrimination.discriminate import Discriminate
from exidyn.trajectories.discrimination.distinction import distinguish, sentences
from exidyn.trajectories.kinds.by_rule import KINDS, by_rule
from exidyn.trajectories.limits.usable_limits import Margins, usable
from exidyn.trajectories.planning.goals import two_models, with_bodies
from exidyn.trajectories.planning.planner import plan
from exidyn.trajectories.planning.wishes import Wishes, rows_of
from exidyn.trajectories.plans.exports import EXPORTS
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_check import limit_use, nominal_torque, violations
from exidyn.trajectories.plans.plan_file import write_plan
from exidyn.trajectories.plans.plan_summary import plan_document

from ..arguments import options
from ..arguments.command import (
    Command,
    Group,
    Option,
    WrongUse,
    any_number,
    integer,
    refuse_with,
    refuse_without,
    table_help,
)
from ..files.clearances import read_clearances
from ..run.expected_fit import expected_fit
from ..terminal.run_summary import plan_table
from ..terminal.stopwatch import Progress, Stopwatch
from .result import Result
from .shown_motion import SHOW_HELP, SHOWN, show_motion

OPTIMIZED = "best"
"""Name of the optimized kind of run; the others are made by rule."""
TRAJECTORY = "trajectory.toml"
"""Default file of the plan."""
SEARCH = 60.0
"""Default search time [s]."""
STAGES = {"make": 0.01, "torque": 0.6, "check": 0.39}
"""Stages of a run made by rule, and their shares of the time."""
COM = Option(
    "--com X Y Z", "center of mass in the flange frame [m]; once for each mass", any_number, [], repeated=True
)
AGAINST = Option("--against ROBOT", "another model of the same arm, to be distinguished from ROBOT")
GOAL = (
    Option(
        "--shapes EFFECT...",
        "effects whose shapes are also unknown, such as stribeck_friction",
        [key for key, effect in EFFECTS.items() if effect.shapes()],
        [],
    ),
    Option(
        "--mass KG...",
        "plan one motion to be run unloaded and with each mass, for the drive gains",
        any_number,
        [],
    ),
    COM,
    Option(
        "--focus NAME...",
        "the only parameters that matter: gain Kr, or in words 'K_r, friction of joint 2'",
        str,
        [],
    ),
    Option("--after FIT", "fit.json of earlier runs, which the new run complements", Path),
    AGAINST,
)
IDENTIFY_ONLY = [option for option in GOAL if option not in (COM, AGAINST)]
"""Options that only apply to runs for identification; --com without --mass has an error of its own."""
LENGTH = Option("--length S", f"duration with rests and leads; default: {Wishes.seconds:g}", any_number)
MOTION = (
    Option(
        "--kind KIND",
        f"{OPTIMIZED}: Optimized by search; "
        + "; ".join(f"{name}: {(kind.__doc__ or '').rstrip('.')}" for name, kind in KINDS.items()),
        (OPTIMIZED, *KINDS),
        OPTIMIZED,
    ),
    Option("--joints JOINT...", "joints that the other kinds move; default: all"),
    LENGTH,
    Option("--period S", "base period; default: several are tried", any_number),
    Option("--harmonics N", "harmonics of each joint", integer, Wishes.harmonics),
    Option("--tick S", "cycle of the controller", any_number, Wishes.tick),
    Option("--start Q...", "pose at start and end [rad]", any_number),
)
LIMITS = (
    Option("--degrees", "--start and --window are in degrees"),
    Option(
        "--window Q...",
        "largest distance from the start pose, 1 or n values [rad]; RSI's AXISCORR",
        any_number,
    ),
    Option("--margin SHARE", "safety margin of velocity, acceleration, jerk and torque", any_number, 0.05),
)


ITERATIONS = Option(
    "--iterations N",
    "iterations of each start instead of a search time, so that any computer plans the same motion",
    integer,
)
SEARCHING = (
    Option("--search S", f"search time; default: {SEARCH:g}", any_number),
    ITERATIONS,
    Option("--seed N", "seed of the first start", integer, 0),
)


@Command(
    "Plan the trajectory that identifies a robot best within its limits; Ctrl-C keeps the best so far. Or "
    "show a planned motion against the limits: a table, and a page of plots.",
    (
        "exidyn excite robot.toml",
        "exidyn excite robot.toml --mass 175 --com 0.1 0 0.2      # a pair of runs, for the drive gains",
        "exidyn excite robot.toml --kind sweeps --joints joint2   # constant velocities, for friction",
        "exidyn excite robot.toml --show trajectory.toml --view   # plots, and the moving arm",
    ),
    (
        Option("robot [ROBOT]", options.ROBOT_FILES),
        options.output_option(
            "FILE", meaning=f"default: {TRAJECTORY}; with --show the page, default: its name with .html"
        ),
        options.JSON,
        options.FULL,
        Group("goal", GOAL),
        Group("motion", MOTION),
        Group("limits in addition to those of the robot", (*LIMITS, options.CELL, options.NO_COLLISION)),
        Group("search", SEARCHING),
        options.CHECK,
        Group("show a planned motion instead", (Option("--show TRAJECTORY", SHOW_HELP, Path), *SHOWN)),
    ),
    table_help("formats of --to", EXPORTS),
)
def excite_command(args: Namespace) -> Result:
    """Plan the motion, print and write it; or show a planned one."""
    if args.show:
        refuse_with("--show", args, [*GOAL, *MOTION, *LIMITS, *SEARCHING, options.CHECK])
        return show_motion(args)
    if not args.robot:
        raise WrongUse("give ROBOT, or --show TRAJECTORY to show a planned motion")
    refuse_without("--show TRAJECTORY", args, SHOWN)
    _require_together(args)
    args.search = SEARCH if args.search is None else args.search
    path = args.output or Path(TRAJECTORY)
    options.require_file(path, "--output", [args.robot, args.against, args.after, args.cell])
    model = read_model(args.robot)
    searched = args.kind == OPTIMIZED
    search_time = args.search if searched and args.iterations is None else 0.0
    with Stopwatch({} if searched else STAGES, search_time) as progress:
        motion, distinguished = _planned(args, model, progress)
        loaded, _ = with_bodies(model, _bodies(args))
        progress(StageText("torque", f"compute the torque of its {motion.trajectory.duration:.0f} s"))
        torque = nominal_torque(motion, loaded)
        progress(StageText("check", "check it against all limits, with stops from every sample"))
        uses, beyond = [*limit_use(motion), torque.use], violations(motion, torque)
        expected = expected_fit([motion], model, _bodies(args), progress=progress) if args.check else None
    write_plan(motion, path)
    motions = [plan_table(motion, uses, beyond) | {"written": str(path)}]
    table = {"exidyn_plan": 1, "motions": motions, "distinguished": distinguished}
    remarks = [*distinguished, *_poor(motion)]
    if expected is not None:
        remarks += expected.sentences
        table["expected"] = asdict(expected)
    file, robot = shlex.quote(str(path)), shlex.quote(args.robot)
    following = [f"excite {robot} --show {file}", f"record {file} --robot {robot}"]
    return Result(plan_document(motion, uses, beyond, remarks), table, [path], next=following)


def _require_together(args: Namespace) -> None:
    """Raise if options exclude each other."""
    if args.kind != OPTIMIZED:
        refuse_with(f"--kind {args.kind}", args, [AGAINST, LENGTH, *IDENTIFY_ONLY])
    elif args.joints:
        raise WrongUse(f"--joints cannot be used with kind '{OPTIMIZED}', in which all joints move")
    if args.against:
        refuse_with("--against", args, IDENTIFY_ONLY)
    if args.search is not None:
        refuse_with("--search", args, [ITERATIONS])


def _planned(args: Namespace, model: Model, progress: Progress) -> tuple[Plan, list[str]]:
    """A motion, and sentences on how well it distinguishes two models."""
    wishes = _wishes(args, model)
    if args.kind != OPTIMIZED:
        progress(StageText("make", f"make {args.kind}"))
        joints = [model.robot.index(joint) for joint in args.joints or ()]
        return by_rule(args.kind, model, wishes, joints, progress), []
    if args.against:
        return _against(args, model, wishes, progress)
    return _search(args, model, wishes, progress), []


def _poor(plan: Plan) -> list[str]:
    """A warning if the best motion is poor."""
    condition = plan.reached if plan.criterion == "condition" else float(plan.details.get("condition", 1.0))
    if not condition < WORST:
        return [
            f"WARNING: the best motion found is poor: condition number {condition:.3g}; from {WORST:g} on, "
            "some combination of parameters is hardly excited. Try a wider range or window, a longer "
            "--period, more --search, or a model with fewer unknowns"
        ]
    return []


def _search(
    args: Namespace, model: Model, wishes: Wishes, progress: Progress, goal: Discriminate | None = None
) -> Plan:
    [motion] = plan(
        model,
        wishes,
        goal=goal,
        seed=args.seed,
        seconds=args.search,
        iterations=args.iterations,
        progress=progress,
    )
    return motion


def _against(args: Namespace, model: Model, wishes: Wishes, progress: Progress) -> tuple[Plan, list[str]]:
    """A run that distinguishes two models, and sentences on how well it does."""
    rival = read_model(args.against)
    names = [model.robot.name, rival.robot.name]
    if names[0] == names[1]:
        names = [str(args.robot), str(args.against)]
    limits, _ = usable(model.robot, wishes.margins, wishes.window, wishes.start)
    goal = two_models((model, rival), names, limits, rows_of(wishes))
    best = _search(args, model, wishes, progress, goal)
    motion = best.trajectory.every(0.01).motion()
    return best, sentences(distinguish(goal, motion, limits, best.trajectory.duration))


def _wishes(args: Namespace, model: Model) -> Wishes:
    """Planning options of the command line."""
    scale = np.where(model.robot.revolute & args.degrees, np.pi / 180.0, 1.0)
    start = options.joint_values(args.start, model.robot.dof, "--start")
    window = options.joint_values(args.window, model.robot.dof, "--window")
    return Wishes(
        harmonics=args.harmonics,
        period=args.period,
        **({} if args.length is None else {"seconds": args.length}),
        margins=replace(
            Margins(), velocity=args.margin, acceleration=args.margin, jerk=args.margin, torque=args.margin
        ),
        window=None if window is None else scale * window,
        start=None if start is None else scale * start,
        tick=args.tick,
        clearances=read_clearances(args, model.robot),
        shapes=args.shapes,
        focus=args.focus,
        bodies=_bodies(args),
        fit=None if args.after is None else read_fit(args.after),
    )


def _bodies(args: Namespace) -> list[tuple[tuple[str, float], ...]]:
    """Known parameters of each payload."""
    centers = args.com or [None] * len(args.mass)
    if len(centers) != len(args.mass):
        raise RobotError(
            f"{len(args.mass)} masses and {len(centers)} centers of mass: --com is the center of mass of a "
            "payload; give it once for each --mass, or not at all"
        )
    return [known_parameters(mass, center) for mass, center in zip(args.mass, centers, strict=True)]
