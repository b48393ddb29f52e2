"""exidyn hold: let the arm float by the torque of a fit, and measure its drift, or the torque to guide it."""

import sys
from argparse import Namespace
from dataclasses import dataclass, replace
from functools import partial
from inspect import signature
from pathlib import Path

import numpy as np

from exidyn.drivers import Driver, Info
from exidyn.identification.contact.contact import Contact, contact
from exidyn.identification.errors import FitError
from exidyn.identification.feedforward.feedforward import SHARE
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.text_table import digits, paragraph, table

from ..arguments.command import Command, Group, Option, positive
from ..arguments.controllers import read_controller
from ..arguments.options import JSON, output_option, payload_name
from ..arguments.run_options import DRIVING, STOPS, require_mock, stop_limits
from ..files.recorded_run import alarm, code_of, free_path, print_where, run_head, run_recorded
from ..jog.there_and_back import run_limits
from ..run.arms import make_driver, standing_arm
from ..run.before import StartRules
from ..run.errors import NotAllowed
from ..run.floating import FADE_IN, Torque, floating_motion
from ..run.perform import Job, Outcome, standing
from ..run.player import RUNNING
from ..run.recorder import require_free
from ..run.run_file import TORQUE
from ..terminal import run_summary
from ..terminal.json_output import hand_over, json_text
from ..terminal.progress import start_progress
from ..terminal.run_summary import confirm, require_attended

SECONDS, DRIFT = 10.0, 5.0
"""Usual time to float [s], and usual largest drift [deg]."""
SPEED = 0.2
"""Largest speed of an arm that floats over its velocity limit [-]: 250 mm/s at the end of a 1 m arm, which
ISO 10218-1 allows near a person, is 0.25 rad/s, and typical limits are 1.5 to 3 rad/s."""
GENTLE = 0.05
"""Share of the limits for the approach to the held position [-]."""
MOVING = 0.05
"""Speed above which a joint counts as guided [rad/s]."""
ADVICE = (
    "; it is held by the torque of the fit alone: support it, keep the emergency stop at hand, and stay out "
    "of its reach until it is seen to float."
)


def hold_torque(fit: Fit, payload: str, guided: bool) -> Torque:
    """Joint torque (n,) [N m] of a position and a velocity that holds the arm, or also compensates friction.

    Raises:
        FitError: Drive gains are unknown, or torque depends on temperature.
    """
    name = fit.model.robot.name
    if fit.unscaled:
        raise FitError(
            f"{name}: drive gains are unknown, so the fit has no torque in N m. State them, then fit again"
        )
    functions = fit.feedforward(payload).functions()
    gravity, friction = functions["gravity"], functions["friction_compensation"]
    if "temperature" in (*signature(gravity).parameters, *signature(friction).parameters):
        raise FitError(f"{name}: torque of the fit depends on temperature, which hold does not follow")
    if not guided:
        return lambda position, velocity: np.asarray(gravity(position))
    return lambda position, velocity: np.asarray(gravity(position) + friction(position, velocity))


@dataclass
class HoldTest:
    """A requested test.

    Attributes:
        args: Parsed command line.
        fit: The fit.
        torque: Torque that holds the arm.
    """

    args: Namespace
    fit: Fit
    torque: Torque

    @property
    def drift(self) -> float:
        """Largest distance from the start [rad]; infinite for an arm that is guided, unless it is stated."""
        degrees = self.args.drift or (np.inf if self.args.guide else DRIFT)
        return float(np.radians(degrees))

    def job(self, info: Info, driver: Driver) -> Job:
        """The job from the arm's current position; its drives are not powered yet.

        Raises:
            NotAllowed: The controller takes no torque, or is only listened to.
            CannotStart: The arm's position is unknown.
        """
        if info.listens or not info.takes_torque:
            raise NotAllowed(
                "this controller takes no torque, so that it cannot let the arm float; the mock does, and "
                "Damiao motors of driver can_mit. exidyn compensate writes the torque for your own program"
            )
        robot = self.fit.model.robot
        position = standing(driver, info)
        watch, current = stop_limits(self.args, robot)
        watch = replace(watch, speed=SPEED, drift=self.drift)
        motion = floating_motion(position, self.args.seconds, info.cycle)
        start = StartRules(speed=GENTLE)
        return Job(robot, motion, run_limits(robot), start, watch, current, torque=self.torque)


@Command(
    "Let the arm float by the torque of a fit, and measure its drift, or the torque that guides it.",
    (
        "exidyn hold exidyn-fit/fit.json                                # a simulated arm",
        "exidyn hold exidyn-fit/fit.json --controller cell.toml --seconds 20",
        "exidyn hold exidyn-fit/fit.json --controller cell.toml --guide -o guided.mcap",
    ),
    (
        Option("fit FIT", "fit.json of exidyn identify", Path),
        Option("--seconds S", "time to float", positive, SECONDS),
        Option(
            "--drift DEG", f"largest distance from the start; default: {DRIFT:g}, with --guide none", positive
        ),
        Option("--guide", "compensate friction too, and let a person move the arm"),
        Option("--payload NAME", "payload of the fit on the flange; default: none", payload_name, ""),
        output_option("FILE", meaning="default: hold.mcap, hold-2.mcap, ..."),
        JSON,
        Group("controller", DRIVING),
        Group("limits that stop the run", STOPS),
    ),
    usage="exidyn hold [-h] FIT [option ...]",
)
def hold_command(args: Namespace) -> int:
    """Check, confirm, let the arm float, record, and measure; return 0 if the test completed."""
    fit = read_fit(args.fit)
    test = HoldTest(args, fit, hold_torque(fit, args.payload, args.guide))
    stop_limits(args, fit.model.robot)  # reports errors in its options before the confirmation
    name, settings = read_controller(args.controller, args.driver, args.set)
    require_mock(args, name)
    driver = _driver(args, name, settings, fit)
    path = free_path(args.output, "hold")
    require_free(path)
    require_attended(driver.simulated, args.yes)
    print(_before(test, name, path), file=sys.stderr)
    confirm(driver.simulated, args.yes, ADVICE)
    head = partial(
        run_head,
        name=path.stem,
        model=fit.model,
        driver=name,
        payload=KnownPayload(args.payload) if args.payload else None,
        commanded=(TORQUE,),
        hold=f"floats by the torque of {args.fit}",
    )
    progress = partial(start_progress, FADE_IN + args.seconds)
    outcome, recorder = run_recorded(driver, lambda info: test.job(info, driver), path, head, progress)
    try:
        _report(test, outcome, path)
    finally:  # whatever the recording is like, an arm that may still move is announced
        print_where(recorder, path, f"contact {path} --fit {args.fit} shows external torques")
        alarm(outcome.unsafe)
    return code_of(outcome)


def _driver(args: Namespace, name: str, settings: dict[str, object], fit: Fit) -> Driver:
    """The driver; the mock gets the arm of --plant with its payload, or else the nominal one of the fit."""
    model = fit.model
    real = read_model(args.plant) if args.plant else model
    payload = next(iter(real.payloads), "") if args.plant else args.payload
    return make_driver(name, settings, model.robot, standing_arm(model.robot, real, args.seed, payload))


def _before(test: HoldTest, driver: str, path: Path) -> str:
    """What the test does, before a person confirms it."""
    args, robot = test.args, test.fit.model.robot
    friction = f"gravity and {100 * SHARE:g} % of friction" if args.guide else "gravity"
    ends = f"{np.degrees(test.drift):g} degrees from the start or " if np.isfinite(test.drift) else ""
    sentence = (
        f"{robot.name}, driver {driver}: the arm stays where it is for {FADE_IN:g} s, then floats for "
        f"{args.seconds:g} s by the torque of {args.fit} for {friction}, with position control off. It is "
        f"stopped at {ends}{100 * SPEED:g} % of its velocity limits. Recorded to {path}."
    )
    return "\n".join(paragraph(sentence))


def _report(test: HoldTest, outcome: Outcome, path: Path) -> None:
    """Drift of each joint, and the external torque that moved it."""
    robot, fit, args = test.fit.model.robot, test.fit, test.args
    [run] = import_source(path, fit.model)
    columns = {"drift": (floating_drift(run), robot.units("rad"))}
    if args.guide:
        guided = guiding_torque(contact(fit, run, payload=args.payload))
        columns["torque to move it"] = guided, robot.units("N m")
    rows = [[joint] for joint in robot.joints]
    for values, units in columns.values():
        for row, value, unit in zip(rows, values, units, strict=True):
            row += [digits(value, 3) if np.isfinite(value) else "-", unit]
    head = ["joint", *(cell for name in columns for cell in (name, "unit"))]
    text = "\n".join(table(head, rows, left=(0, 2, 4)))
    content = {"exidyn_hold": 1, "joints": list(robot.joints)} | {
        name.replace(" ", "_"): [float(value) if np.isfinite(value) else None for value in values]
        for name, (values, _) in columns.items()
    }
    of_run = {name: value for name, value in run_summary.table(outcome).items() if name != "exidyn_run"}
    page = f"{run_summary.after(outcome)}\n\n{text}"
    hand_over(page, json_text(content | of_run | {"written": str(path)}), args.json)


def floating_drift(run: Recording) -> np.ndarray:
    """Largest distance of each joint from where it began to float, shape (n,) [rad]; NaN if it did not."""
    position, timing = run.signals["position"], run.timing
    assert timing is not None
    running = timing.time[timing.stage == RUNNING]
    if not len(running):
        return np.full(position.values.shape[1], np.nan)
    rows = (position.time >= running[0] + FADE_IN) & (position.time <= running[-1])
    floating = position.values[rows]
    if not len(floating):
        return np.full(position.values.shape[1], np.nan)
    return np.asarray(np.nanmax(np.abs(floating - floating[0]), axis=0))


def guiding_torque(result: Contact) -> np.ndarray:
    """Median external torque of each joint while it moved, shape (n,) [N m]; NaN for joints that did not."""
    estimates = result.estimates
    moving = np.abs(estimates.velocity) > MOVING
    torque = np.where(moving & np.isfinite(estimates.torque), np.abs(estimates.torque), np.nan)
    known = np.isfinite(torque).any(axis=0)
    median = np.full(torque.shape[1], np.nan)
    median[known] = np.nanmedian(torque[:, known], axis=0)
    return median
