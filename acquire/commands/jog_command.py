"""exidyn jog: one joint slowly a little way and back, and whether it does as in the robot file."""

import sys
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from exidyn.drivers import Driver, Info
from exidyn.drivers.values import checked
from exidyn.identification.arm.robot import Robot
from exidyn.identification.errors import UnknownJoint
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments.command import Command, Group, Option, number
from ..arguments.controllers import read_controller
from ..arguments.exit_codes import DONE, WRONG
from ..arguments.options import BODY, JSON, output_option, require_json, robot_option
from ..arguments.run_options import DRIVING, STOPS, body_of, facts_of, require_mock, stops_of
from ..files.recorded_run import alarm, code_of, free_path, print_where, run_head, run_recorded
from ..jog import jog_text
from ..jog.effort import FlangeWay, flange_way
from ..jog.judgements import Judgement, Verdict, judge
from ..jog.there_and_back import (
    MOST_SLIDE,
    MOST_TURN,
    USUAL_SLIDE,
    USUAL_TURN,
    Kept,
    Way,
    duration,
    require_room,
    run_limits,
    there_and_back,
)
from ..run.arms import make_driver, standing_arm, with_body
from ..run.before import StartRules
from ..run.errors import NotAllowed, print_line
from ..run.perform import LISTEN_TIME, MIN_SAMPLES, Job, Outcome
from ..run.recorder import require_free
from ..terminal import run_summary
from ..terminal.json_output import hand_over, json_text
from ..terminal.progress import start_progress
from ..terminal.run_summary import confirm, require_attended

SLIPPED = "It moved when its drives were powered: look at its brakes, and at gains and zeros of its drives"
ADVICE = "; the joint moves slowly, and Ctrl-C brakes it."
GENTLE = 0.05
"""Share of the limits on the way, below half a degree, to where the motion begins [-]."""


@dataclass
class Jog:
    """One jog, as it is asked for, and what was found when the arm was.

    Attributes:
        model: Nominal, with what it carries.
        way: To be gone.
        given: The command line.
        driver: Not open yet.
        flange: Where it should go; None until the arm is found.
    """

    model: Model
    way: Way
    given: Namespace
    driver: Driver
    flange: FlangeWay | None = field(default=None)

    def job(self, info: Info) -> Job:
        """What is to be done, from where the arm stands; its drives are not powered yet.

        Raises:
            NotAllowed: The controller takes no commands.
            CannotStart: The joint has no room, or its position is unknown.
        """
        robot = self.model.robot
        if info.listens:
            raise NotAllowed("the controller is only listened to (ONLYSEND), so that no joint can be jogged")
        position = _standing(self.driver, info)
        require_room(robot, self.way, position)
        self.flange = flange_way(robot, position, self.way)
        print_line(jog_text.before_motion(robot, self.way, position, self.flange))
        limits = run_limits(robot)
        watch, current = stops_of(self.given, robot)
        motion = there_and_back(position, self.way, limits, info.cycle)
        return Job(robot, motion, limits, StartRules(speed=GENTLE, advice=SLIPPED), watch, current)


@Command(
    "Move one joint slowly a little way and back, and judge its sign, scale and gain.",
    (
        "exidyn jog --robot cobot --joint 3                         # a simulated arm",
        "exidyn jog --controller cell.toml --robot robot.toml --joint 3 --degrees 2",
        "exidyn jog --controller cell.toml --robot robot.toml --joint elbow --degrees -5 -o elbow.mcap",
    ),
    (
        robot_option(required=True),
        Option("--joint JOINT", "its number from 1, or its name", required=True),
        Group(
            "",
            (
                Option(
                    "--degrees DEG",
                    f"from where it stands, up to {np.degrees(MOST_TURN):g} either way; "
                    f"default: {np.degrees(USUAL_TURN):g}",
                    number,
                ),
                Option(
                    "--mm MM",
                    f"where it slides, up to {1e3 * MOST_SLIDE:g} either way; default: {1e3 * USUAL_SLIDE:g}",
                    number,
                ),
            ),
        ),
        output_option("FILE", meaning="default: jog.mcap, jog-2.mcap, ..."),
        JSON,
        Group("controller", DRIVING),
        Group("what stops the run", STOPS),
        Group("what hangs on the flange", BODY),
    ),
    usage="exidyn jog [-h] --robot ROBOT --joint JOINT [option ...]",
)
def jog_command(given: Namespace) -> int:
    """Check, ask, move, record, judge."""
    payload = body_of(given)
    nominal = read_model(given.robot)
    model = with_body(nominal, payload)
    way = _way(given, model.robot)
    stops_of(given, model.robot)  # so that errors in it are reported before anything is asked
    name, settings = read_controller(given.controller, given.driver, given.set)
    driver = _driver(given, name, settings, model, payload)
    path = free_path(given.output, "jog")
    require_free(path)
    require_json(given.json)
    require_attended(driver.simulated, given.yes)
    print(jog_text.before(model.robot, way, facts_of(given, name, path)), file=sys.stderr)
    confirm(driver.simulated, given.yes, ADVICE)
    jog = Jog(model, way, given, driver)
    kept = Kept()
    joint, unit = model.robot.joints[way.joint], "rad" if model.robot.revolute[way.joint] else "m"
    distance = f"{joint} by {way.distance:g} {unit} and back"
    head = partial(run_head, name=path.stem, model=nominal, driver=name, payload=payload, jog=distance)
    progress = partial(start_progress, duration(way))
    outcome, recorder = run_recorded(driver, jog.job, path, head, progress, [kept])
    judgements = judge(kept.course(), way, model, payload.name if payload else "")
    _report(jog, outcome, judgements, path)
    print_where(recorder, path, f"info {path} shows what happened")
    alarm(outcome.unsafe)
    if (code := code_of(outcome)) != DONE:
        return code
    return WRONG if any(one.verdict is Verdict.WRONG for one in judgements) else DONE


def _way(given: Namespace, robot: Robot) -> Way:
    """The joint, and how far."""
    joint = _joint(given.joint, robot)
    revolute = bool(robot.revolute[joint])
    if (given.mm if revolute else given.degrees) is not None:
        kind, option = ("is revolute", "--degrees") if revolute else ("is prismatic", "--mm")
        raise NotAllowed(f"{robot.joints[joint]} {kind}: give the distance with {option}")
    if revolute:
        return Way.of(robot, joint, USUAL_TURN if given.degrees is None else float(np.radians(given.degrees)))
    return Way.of(robot, joint, USUAL_SLIDE if given.mm is None else 1e-3 * given.mm)


def _joint(given: str, robot: Robot) -> int:
    if given in robot.joints:
        return robot.index(given)
    if given.isdecimal() and 1 <= int(given) <= robot.dof:
        return int(given) - 1
    raise UnknownJoint(given, f"{robot.name} (numbers 1 to {robot.dof})", robot.joints)


def _driver(
    given: Namespace,
    name: str,
    settings: dict[str, object],
    model: Model,
    payload: KnownPayload | None,
) -> Driver:
    """The driver, and for the mock its arm."""
    require_mock(given, name)
    real = with_body(read_model(given.plant), payload) if given.plant else model
    plant = standing_arm(model.robot, real, given.seed, payload.name if payload else "")
    return make_driver(name, settings, model.robot, plant)


def _standing(driver: Driver, info: Info) -> np.ndarray:
    """Where the arm stands, shape (n,) [rad] or [m]: where it is held, or the median of what is received.

    A controller that holds the arm already wants an answer in every cycle, and from the first exchange on it
    gets none but by exchanges; what is still to be planned would come in between.
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


def _report(jog: Jog, outcome: Outcome, judgements: Sequence[Judgement], path: Path) -> None:
    robot, json_file = jog.model.robot, jog.given.json
    content = {"exidyn_jog": 1, **jog_text.json_table(robot, jog.way, judgements)}
    run = {name: value for name, value in run_summary.table(outcome).items() if name != "exidyn_run"}
    page = run_summary.after(outcome) + "\n" + jog_text.after(robot, jog.way, judgements, jog.flange)
    hand_over(page, json_text(content | run | {"written": str(path)}), json_file)
