"""exidyn record: play a planned motion on a controller and record the run."""

import sys
from argparse import Namespace
from collections.abc import Callable
from functools import partial
from pathlib import Path

from exidyn.drivers import Driver, Info, Sample, known_drivers
from exidyn.drivers.driver import Plant
from exidyn.identification.effects import Payload
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.robot_files.surroundings import read_surroundings
from exidyn.identification.simulation.simulate import as_built
from exidyn.trajectories.clearances.clearance import Clearance
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import plan_text, read_plan
from exidyn.trajectories.plans.plan_limits import within
from exidyn.trajectories.plans.plan_summary import run_cost

from ..arguments.command import Command, Group, Option, name_lines
from ..arguments.controllers import read_controller
from ..arguments.options import (
    BODY,
    CELL,
    JSON,
    NAME,
    NO_COLLISION,
    PACKAGES,
    PLAN,
    SPEED,
    output_option,
    require_json,
    robot_option,
)  # fmt: skip
from ..arguments.run_options import DRIVING, STOPS, body_of, check_length, facts_of, require_mock, stops_of
from ..files.clearances import read_clearances, sources_of
from ..files.recorded_run import alarm, code_of, free_path, print_where, run_head, run_recorded, warn
from ..run.arms import make_driver, noise_seed, simulated_arm
from ..run.before import CheckedPlan, StartRules, check_plan, require_clear
from ..run.perform import Job, Outcome
from ..run.pipe import PipeSink
from ..run.recorder import require_free
from ..run.simulated import rehearse
from ..terminal import run_summary
from ..terminal.json_output import hand_over, json_text
from ..terminal.progress import start_progress
from ..terminal.run_summary import confirm, require_attended
from ..views.live_view import LOCAL, PORT, Targets, require_showable, start_view

MOTION = (
    SPEED,
    Option("--long", "a run of more than an hour is meant"),
    Option("--approach", "go slowly to where the motion begins, from wherever the arm is"),
    PACKAGES,
    NO_COLLISION,
    CELL,
    Option("--dry-run", "only rehearse on the mock, and record that"),
    Option("--no-rehearsal", "do not rehearse on the mock before"),
)
VIEW = (
    Option("--view", "in Rerun's viewer"),
    Option(
        "--serve [ADDRESS:PORT]",
        f"in a browser; default: {LOCAL}:{PORT}, which only this machine reaches",
        alone=f"{LOCAL}:{PORT}",
    ),
    Option("--save FILE", "as a file for Rerun's viewer (.rrd)", Path),
)


@Command(
    "Play a planned motion on a controller and record the run.",
    (
        "exidyn record trajectory.toml --robot kr270    # a simulated arm",
        "exidyn record trajectory.toml --robot robot.toml --controller cell.toml --speed 10 --view",
        "exidyn record trajectory.toml --robot robot.toml --controller cell.toml --mass 175 -o loaded.mcap",
    ),
    (
        PLAN,
        robot_option(required=True),
        output_option("FILE", meaning="default: run.mcap, run-2.mcap, ..."),
        JSON,
        NAME,
        Option("--note TEXT", "whatever explains the run, kept in the file", default=""),
        Group("controller", DRIVING),
        Group("motion", MOTION),
        Group("what stops the run", STOPS),
        Group("what hangs on the flange", BODY),
        Group("live view", VIEW),
    ),
    name_lines(
        "drivers ('exidyn drivers DRIVER' lists the settings of one)",
        {name: entry.purpose for name, entry in known_drivers().items()},
    ),
    "exidyn record [-h] TRAJECTORY --robot ROBOT [option ...]",
)
def record_command(given: Namespace) -> int:
    """Check, rehearse, ask, run, record; 0 if the run came to its end."""
    payload = body_of(given)
    plan = read_plan(given.plan)
    check_length(plan.trajectory.duration, given.speed, given.long)
    ready = check_plan(plan, read_model(given.robot), given.speed, payload)
    name, settings = read_controller(given.controller, given.driver, given.set)
    if not given.dry_run:
        require_mock(given, name)
    path, targets = free_path(given.output, "run"), Targets(given.view, given.serve, given.save)
    run = given.name or path.stem
    plant = _plant(given, ready, payload, run)
    driver = make_driver(name, settings, ready.model.robot, plant)
    if given.dry_run:
        rehearsed = {"cycle": _cycle(driver, ready)}
        name, driver = "mock", make_driver("mock", rehearsed, ready.model.robot, plant)
    require_free(path)
    require_json(given.json)
    require_showable(targets)
    require_attended(driver.simulated, given.yes)
    clearances = _clearances(given, plan, ready.model)
    require_clear(ready, clearances)
    job = _job(given, ready, clearances)
    speed = f"{100 * given.speed:g} % of the planned"
    takes = run_cost(ready.plan, _cycle(driver, ready))
    facts = facts_of(given, name, path, speed=speed, takes=takes)
    if name == "mock" and not (given.plant or given.dry_run):
        facts["simulated arm"] = "values of the robot file, each off by up to its tolerance; see --plant"
    print(run_summary.before(ready, facts), file=sys.stderr)
    warn(ready.warnings)
    if not driver.simulated:
        make_driver(name, settings, ready.model.robot, plant).find()
    if not driver.simulated and not given.no_rehearsal:
        print("the controller answers; rehearsing on a simulated arm", file=sys.stderr)
        carried = payload.name if payload else ""
        rehearse(job, ready.model, _cycle(driver, ready), carried, start_progress(job.motion.duration))
    confirm(driver.simulated, given.yes)
    # Read and written before the loop, which has no time for it; at full speed, as the file has it.
    head = partial(
        run_head,
        name=run,
        model=read_model(given.robot),
        driver=name,
        payload=payload,
        trajectory=plan_text(within(plan, ready.model.robot)),
        speed=f"{given.speed:g}",
        note=given.note,
    )
    outcome = _record(targets, driver, job, path, head, given.json)
    return code_of(outcome)


def _cycle(driver: Driver, ready: CheckedPlan) -> float:
    """Between commands [s]; a controller that states none has that of the plan."""
    return float(getattr(driver.settings, "cycle", ready.plan.tick))


def _plant(
    given: Namespace, ready: CheckedPlan, payload: KnownPayload | None, run: str
) -> Callable[[], Plant]:
    """What makes the arm of the mock for a run, standing where the motion begins."""

    def make() -> Plant:
        model = ready.model
        if given.plant:
            model = read_model(given.plant)
            if payload is not None and not model.payloads:
                model = model + Payload(payload.name, payload.known)
        elif not given.dry_run:
            model = as_built(model)
        start = ready.plan.trajectory.state_at(0.0).position
        seed = noise_seed(given.seed, run)
        return simulated_arm(model, start, seed=seed, payload=payload.name if payload else "")

    return make


def _job(given: Namespace, ready: CheckedPlan, clearances: tuple[Clearance, ...]) -> Job:
    robot = ready.model.robot
    start = StartRules(approach=given.approach, clearances=clearances)
    watch, current = stops_of(given, robot)
    return Job(robot, ready.plan.trajectory, ready.limits, start, watch, current)


def _clearances(given: Namespace, plan: Plan, model: Model) -> tuple[Clearance, ...]:
    """What the way to the motion and the motion must keep clear of.

    A motion was planned clear of the arm itself, unless its file was edited; what stands around it may have
    been written down since.
    """
    around = read_surroundings(sources_of(given.robot, given.region))
    if not (given.approach or plan.edited or around):
        return ()
    return read_clearances(
        given.robot,
        model.robot,
        cell=given.region,
        collision=not given.no_collision,
        packages=given.packages,
    )


def _record(
    targets: Targets,
    driver: Driver,
    job: Job,
    path: Path,
    head: Callable[[Info], Callable[[Sample], bytes]],
    json_file: Path | None = None,
) -> Outcome:
    """Run, and print how it went."""

    def viewers() -> list[PipeSink]:
        return [*start_view(targets), *start_progress(job.motion.duration)]

    outcome, recorder = run_recorded(driver, job, path, head, viewers)
    table = run_summary.table(outcome) | {"written": str(path)}
    hand_over(run_summary.after(outcome), json_text(table), json_file)
    advice = "identify {} finds the dynamics in it" if outcome.stop is None else "info {} shows what happened"
    print_where(recorder, path, advice.format(path))
    alarm(outcome.unsafe)
    return outcome
