"""exidyn jog: move one joint slowly a short distance and back, and compare it with the robot file."""

import shlex
import sys
from argparse import Namespace
from functools import partial

import numpy as np

from exidyn.drivers import Driver, Info
from exidyn.drivers.values import checked
from exidyn.identification.arm.robot import Robot
from exidyn.identification.errors import UnknownJoint
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments import run_options
from ..arguments.command import Command, Group, Option, number
from ..arguments.options import BODY, FULL, JSON, output_option, robot_option
from ..arguments.parser import DONE, WRONG
from ..files.recorded_run import free_path, report_run, run_head, run_recorded
from ..jog import jog_text
from ..jog.effort import flange_travel
from ..jog.judgements import Verdict, judge
from ..jog.there_and_back import (
    MOST_SLIDE,
    MOST_TURN,
    USUAL_SLIDE,
    USUAL_TURN,
    MemorySink,
    Travel,
    duration,
    require_room,
    run_limits,
    there_and_back,
)
from ..run.arms import make_driver, standing_arm, with_body
from ..run.before import StartRules
from ..run.errors import NotAllowed, print_line
from ..run.perform import LISTEN_TIME, MIN_SAMPLES, Job
from ..run.recorder import require_free
from ..run.stopping.watch import WatchLimits
from ..terminal import run_summary
from ..terminal.progress import start_progress
from ..terminal.run_summary import confirm, require_attended

SLIPPED = "It moved when its drives were powered: check its brakes, and gains and zeros of its drives"
ADVICE = "; the joint moves slowly, and Ctrl-C stops it."
GENTLE = 0.05
"""Share of the limits for the approach of less than half a degree to the start of the motion [-]."""


@Command(
    "Move one joint slowly a short distance and back, and judge its sign, scale and gain.",
    (
        "exidyn jog 3 --robot cobot                         # a simulated arm",
        "exidyn jog 3 --controller cell.toml --robot robot.toml --degrees 2",
        "exidyn jog elbow --controller cell.toml --robot robot.toml --degrees -5 -o elbow.mcap",
    ),
    (
        Option("joint JOINT", "number of the joint from 1, or its name"),
        robot_option(required=True),
        Group(
            "",
            (
                Option(
                    "--degrees DEG",
                    f"travel of a revolute joint, up to {np.degrees(MOST_TURN):g} in either direction; "
                    f"default: {np.degrees(USUAL_TURN):g}",
                    number,
                ),
                Option(
                    "--mm MM",
                    f"travel of a prismatic joint, up to {1e3 * MOST_SLIDE:g} in either direction; "
                    f"default: {1e3 * USUAL_SLIDE:g}",
                    number,
                ),
            ),
        ),
        output_option("FILE", meaning="default: jog.mcap, jog-2.mcap, ..."),
        JSON,
        FULL,
        Group("controller", run_options.DRIVING),
        Group("limits that stop the run", run_options.STOPS),
        Group("payload on the flange", BODY),
    ),
    usage="exidyn jog [-h] JOINT --robot ROBOT [option ...]",
)
def jog_command(args: Namespace) -> int:
    """Check, confirm, move, record, and judge the joint."""
    payload = run_options.payload_of(args)
    nominal = read_model(args.robot)
    model = with_body(nominal, payload)
    travel = _travel(args, model.robot)
    stops = run_options.stop_limits(args, model.robot)
    name, settings = run_options.read_controller(args.controller, args.driver, args.set)
    run_options.require_mock(args, name)
    real = with_body(read_model(args.plant), payload) if args.plant else model
    plant = standing_arm(model.robot, real, args.seed, payload.name if payload else "")
    driver = make_driver(name, settings, model.robot, plant)
    path = free_path(args.output, "jog")
    require_free(path)
    require_attended(driver.simulated, args.yes)
    print(jog_text.before(model.robot, travel, run_options.run_facts(args, name, path)), file=sys.stderr)
    confirm(driver.simulated, args.yes, ADVICE)
    job, sink = partial(_job, model.robot, travel, stops, driver), MemorySink()
    joint, unit = model.robot.joints[travel.joint], "rad" if model.robot.revolute[travel.joint] else "m"
    distance = f"{joint} by {travel.distance:g} {unit} and back"
    head = partial(run_head, name=path.stem, model=nominal, driver=name, payload=payload, jog=distance)
    progress = partial(start_progress, duration(travel))
    outcome, recorder = run_recorded(driver, job, path, head, progress, [sink])
    judgements = judge(sink.course(), travel, model, payload.name if payload else "")
    page = "\n".join([run_summary.after(outcome, args.full), jog_text.after(model.robot, travel, judgements)])
    run = {name: value for name, value in run_summary.table(outcome).items() if name != "exidyn_run"}
    table = {"exidyn_jog": 1, **jog_text.json_table(model.robot, travel, judgements), **run}
    code = report_run(outcome, recorder, path, f"info {shlex.quote(str(path))}", page, table, args.json)
    wrong = any(judgement.verdict is Verdict.WRONG for judgement in judgements)
    return WRONG if code == DONE and wrong else code


def _travel(args: Namespace, robot: Robot) -> Travel:
    """Joint and distance of the command line."""
    joint = _joint(args.joint, robot)
    revolute = bool(robot.revolute[joint])
    if (args.mm if revolute else args.degrees) is not None:
        kind, option = ("is revolute", "--degrees") if revolute else ("is prismatic", "--mm")
        raise NotAllowed(f"{robot.joints[joint]} {kind}: give the distance with {option}")
    if revolute:
        return Travel.of(
            robot, joint, USUAL_TURN if args.degrees is None else float(np.radians(args.degrees))
        )
    return Travel.of(robot, joint, USUAL_SLIDE if args.mm is None else 1e-3 * args.mm)


def _joint(name: str, robot: Robot) -> int:
    if name in robot.joints:
        return robot.index(name)
    if name.isdecimal() and 1 <= int(name) <= robot.dof:
        return int(name) - 1
    raise UnknownJoint(name, f"{robot.name} (numbers 1 to {robot.dof})", robot.joints)


def _job(
    robot: Robot, travel: Travel, stops: tuple[WatchLimits, np.ndarray | None], driver: Driver, info: Info
) -> Job:
    """The job from the arm's current position; its drives are not powered yet.

    Raises:
        NotAllowed: If the controller takes no commands.
        CannotStart: If the joint would leave its limits, or its position is unknown.
    """
    if info.listens:
        raise NotAllowed("the controller only sends (ONLYSEND), so that no joint can be jogged")
    position = _standing(driver, info)
    require_room(robot, travel, position)
    print_line(jog_text.before_motion(robot, travel, position, flange_travel(robot, position, travel)))
    limits = run_limits(robot)
    motion = there_and_back(position, travel, limits, info.cycle)
    return Job(robot, motion, limits, StartRules(speed=GENTLE, advice=SLIPPED), *stops)


def _standing(driver: Driver, info: Info) -> np.ndarray:
    """Current position, shape (n,) [rad] or [m]: the held position, or the median of received ones.

    A controller that already holds the arm expects an answer in every cycle from the first exchange on, and
    planning would delay the answers.
    """
    held = driver.held()
    if held is not None:
        return held
    count = max(round(LISTEN_TIME / info.cycle), MIN_SAMPLES)
    seen = np.array([checked(driver.exchange(None)).position for _ in range(count)])
    known = np.isfinite(seen).any(axis=0)
    position = np.full(seen.shape[1], np.nan)
    position[known] = np.nanmedian(seen[:, known], axis=0)
    return position
