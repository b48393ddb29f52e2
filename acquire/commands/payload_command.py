"""exidyn payload: identify the payload on the flange, or plan the motion for it."""

import shlex
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.model import Model
from exidyn.identification.pages.payload_document import payload_document, payload_table
from exidyn.identification.payload.formats import FORMATS
from exidyn.identification.payload.payload_estimate import PayloadEstimate
from exidyn.identification.payload.weigh import weigh
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.progress import StageText
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.text_table import digits
from exidyn.trajectories.planning.payload_motion import HEAVIEST, AnyPayload, payload_plan
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_check import limit_use, nominal_torque, violations
from exidyn.trajectories.plans.plan_file import parse_plan, write_plan
from exidyn.trajectories.plans.plan_summary import plan_document

from ..arguments import options
from ..arguments.command import (
    Command,
    Group,
    Option,
    WrongUse,
    any_number,
    name_lines,
    positive,
    refuse_with,
    refuse_without,
)
from ..files.clearances import read_clearances
from ..files.given_runs import read_runs
from ..terminal.run_summary import plan_table
from ..terminal.stopwatch import Progress, Stopwatch
from .result import Result

LENGTH = 18.0
"""Default duration of the motion [s]."""
SEARCH = 30.0
"""Default search time [s]."""
OPEN = 0.3
"""Mean relative standard deviation beyond which the payload would count as not determined."""
MOVING, POSES = "moving", "poses"
"""Kinds of motion."""
DURATION = Option("--length S", f"duration with rests and leads; default: {LENGTH:g}", positive, LENGTH)
PLAN = (
    Option("--up-to KG", "plan the motion for payloads up to this mass; needs --robot or --fit", positive),
    Option("--reach M", "largest distance of its center from the flange; default: 0.2", positive, 0.2),
    Option(
        "--kind KIND",
        f"{POSES}: rest at poses, for arms that must be slow: mass and center only; default: {MOVING}",
        (MOVING, POSES),
        MOVING,
    ),
    DURATION,
    Option("--search S", f"search time; default: {SEARCH:g}", positive, SEARCH),
    Option("--start Q...", "pose at start and end [rad]", any_number),
    options.output_option("FILE", Path("payload.toml")),
    options.seed_option("seed of the search"),
    options.CELL,
    options.NO_COLLISION,
)
RUNS = Option("runs [RUN...]", "run with the payload (.mcap, .csv); the same payload in all", Path, [])
FORMS = Option(
    "--for CONTROLLER...", "also print the payload as these take it, see below", FORMATS, [], dest="forms"
)
EMPTY = Option("--empty RUN...", "run without the payload, best of the same motion", Path, [])
COM = Option("--com X Y Z", "its center of mass in the flange frame, if it is known [m]", any_number)
STAGES = {"read": 0.1, "units": 0.3, "filter": 0.1, "estimate": 0.35, "check": 0.15}
"""Stages and their shares of the time."""


@Command(
    "Identify the payload on the flange: mass, center of mass, inertia, and 95 % intervals.",
    (
        "exidyn payload loaded.mcap --fit exidyn-fit/fit.json --for ur",
        "exidyn payload loaded.mcap --empty empty.mcap --for kuka abb",
        "exidyn payload loaded.csv --robot arm.urdf      # the widest intervals",
        "exidyn payload --up-to 10 --robot robot.toml -o weigh.toml",
    ),
    (
        RUNS,
        Option("--fit FIT", "fit.json of the arm without the payload: the narrowest intervals", Path),
        EMPTY,
        options.robot_option("replaces the robot in the recordings"),
        COM,
        FORMS,
        *options.FILTERS,
        options.JSON,
        options.FULL,
        options.AS_RECORDED,
        Group("plan the motion instead", PLAN),
    ),
    name_lines("controllers", {name: form.title for name, form in FORMATS.items()}),
)
def payload_command(args: Namespace) -> Result:
    """Identify the payload and print it, or plan the motion for it."""
    if args.up_to:
        refuse_with("--up-to", args, [RUNS, EMPTY, COM, FORMS, *options.FILTERS, options.AS_RECORDED])
        return _plan(args)
    refuse_without("--up-to KG", args, PLAN)
    if not args.runs:
        raise WrongUse("give a run with the payload, or --up-to KG to plan the motion for one")
    if args.fit and args.empty:
        raise WrongUse("--fit and --empty cannot be used together: the fit already knows the empty arm")
    if args.fit and args.robot:
        raise WrongUse("--fit and --robot cannot be used together: the fit contains its robot")
    with Stopwatch(STAGES) as progress:
        progress(StageText("read", "read the recordings"))
        result = _weighed(args, progress)
    following = [] if args.forms else [f"{args.typed} --for CONTROLLER"]
    table = payload_table(result, args.forms)
    return Result(payload_document(result, args.forms), table, next=following)


def _weighed(args: Namespace, progress: Progress) -> PayloadEstimate:
    """The payload of the runs."""
    fit = read_fit(args.fit) if args.fit else None
    model = read_model(args.robot) if args.robot else None
    runs = _read(args.runs, model, fit)
    result = weigh(
        runs,
        fit=fit,
        empty=_read(args.empty, model, fit),
        model=model,
        com=args.com,
        filtering=Filtering(None, args.position_cutoff, args.torque_cutoff, args.standstill),
        as_recorded=args.as_recorded,
        progress=progress,
    )
    beyond = _beyond_plan(result.mass.low, [run.trajectory for run in runs if run.trajectory])
    return replace(result, warnings=(*beyond, *result.warnings))


def _beyond_plan(mass: float, trajectories: Sequence[str]) -> list[str]:
    """A warning if a payload of at least this mass [kg] exceeds what the motions of the runs allow."""
    details = [parse_plan(text).details for text in trajectories]
    allowed = [float(detail[HEAVIEST]) for detail in details if HEAVIEST in detail]
    if not allowed or mass <= min(allowed):
        return []
    return [
        f"The payload is heavier than the {min(allowed):g} kg for which the motion was planned (--up-to): "
        "torque limits may have been exceeded. Plan the motion again for it."
    ]


def _read(paths: list[Path], model: Model | None, fit: Fit | None) -> list[Recording]:
    """Recordings of files; tables without a robot have that of the fit."""
    return read_runs(paths, fit.model if model is None and fit is not None else model)


def _plan(args: Namespace) -> Result:
    """Plan the motion, print and write it."""
    if not (args.robot or args.fit):
        raise WrongUse("--up-to needs the arm as --robot or --fit")
    if args.kind == POSES:
        refuse_with(f"--kind {POSES}", args, [DURATION])
    options.require_file(args.output, "--output", [args.robot, args.fit])
    fit = read_fit(args.fit) if args.fit else None
    model = read_model(args.robot) if fit is None else fit.model
    with Stopwatch({}, 0.0 if args.kind == POSES else args.search) as progress:
        motion = _planned(args, model, fit, progress)
        torque = nominal_torque(motion, model)
    uses, beyond = [*limit_use(motion), torque.use], violations(motion, torque)
    write_plan(motion, args.output)
    remarks = []
    if motion.reached > OPEN:
        remarks.append(
            "This motion would not determine the payload: its mean relative standard deviation is "
            f"{digits(motion.reached, 2)}, limit {OPEN:g}. Try a larger --length or --search."
        )
    table = {"exidyn_plan": 1, "motions": [plan_table(motion, uses, beyond) | {"written": str(args.output)}]}
    following = [f"record {shlex.quote(str(args.output))} --robot {shlex.quote(args.robot or 'ROBOT')}"]
    return Result(plan_document(motion, uses, beyond, remarks), table, [args.output], next=following)


def _planned(args: Namespace, model: Model, fit: Fit | None, progress: Progress) -> Plan:
    """The motion for payloads up to --up-to."""
    clearances = read_clearances(args, model.robot) if args.robot else ()
    start = options.joint_values(args.start, model.robot.dof, "--start")
    wishes = Wishes(seconds=args.length, start=start, clearances=clearances, fit=fit)
    return payload_plan(
        model,
        AnyPayload(args.up_to, args.reach),
        wishes,
        poses=args.kind == POSES,
        seed=args.seed,
        seconds=args.search,
        progress=progress,
    )
