"""exidyn record: play a planned motion on a controller, and record the run."""

import shlex
import sys
from argparse import Namespace
from collections.abc import Callable
from functools import partial

from exidyn.drivers import known_drivers
from exidyn.drivers.driver import Plant
from exidyn.identification.effects import Payload
from exidyn.identification.errors import NotExcited
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.robot_files.surroundings import read_surroundings
from exidyn.identification.simulation.simulate import as_built
from exidyn.identification.text_table import paragraph
from exidyn.trajectories.clearances.clearance import Clearance
from exidyn.trajectories.plans.plan import Plan, within
from exidyn.trajectories.plans.plan_file import plan_text, read_plan
from exidyn.trajectories.plans.plan_summary import run_cost

from ..arguments import options, run_options
from ..arguments.command import Command, Group, Option, name_lines
from ..files.clearances import read_clearances, sources_of
from ..files.recorded_run import free_path, report_run, run_head, run_recorded, warn
from ..run.arms import make_driver, noise_seed, simulated_arm
from ..run.before import CheckedPlan, StartRules, check_plan, require_clear
from ..run.expected_fit import expected_fit
from ..run.perform import Job
from ..run.pipe import PipeSink
from ..run.recorder import require_free
from ..run.simulated import rehearse
from ..terminal import run_summary
from ..terminal.progress import start_progress
from ..terminal.run_summary import confirm, require_attended
from ..views.live_view import VIEW, Targets, require_showable, start_view

MOTION = (
    options.SPEED,
    Option("--long", "allow a run of more than an hour"),
    Option("--approach", "move slowly from the current position to the start of the motion"),
    options.NO_COLLISION,
    options.CELL,
    Option("--dry-run", "only rehearse on the mock, and record the rehearsal"),
    Option("--no-rehearsal", "do not rehearse on the mock first"),
    options.CHECK,
)


@Command(
    "Play a planned motion on a controller, and record the run.",
    (
        "exidyn record trajectory.toml --robot kr270    # a simulated arm",
        "exidyn record trajectory.toml --robot robot.toml --controller cell.toml --speed 10 --view",
        "exidyn record trajectory.toml --robot robot.toml --controller cell.toml --mass 175 -o loaded.mcap",
    ),
    (
        options.PLAN,
        options.robot_option(required=True),
        options.output_option("FILE", meaning="default: run.mcap, run-2.mcap, ..."),
        options.JSON,
        options.FULL,
        Group("controller", run_options.DRIVING),
        Group("motion", MOTION),
        Group("limits that stop the run", run_options.STOPS),
        Group("payload on the flange", options.BODY),
        Group("live view", VIEW),
    ),
    name_lines(
        "drivers ('exidyn init --driver DRIVER' lists the settings of one)",
        {name: entry.purpose for name, entry in known_drivers().items()},
    ),
    "exidyn record [-h] TRAJECTORY --robot ROBOT [option ...]",
)
def record_command(args: Namespace) -> int:
    """Check, rehearse, confirm, run and record; return 0 if the run completed."""
    payload = run_options.payload_of(args)
    plan = read_plan(args.plan)
    run_options.check_duration(plan.trajectory.duration, args.speed, args.long)
    ready = check_plan(plan, read_model(args.robot), args.speed, payload)
    name, settings = run_options.read_controller(args.controller, args.driver, args.set)
    if not args.dry_run:
        run_options.require_mock(args, name)
    path, targets = free_path(args.output, "run"), Targets(args.view, args.serve, args.save)
    plant = _plant(args, ready, payload, path.stem)
    driver = make_driver(name, settings, ready.model.robot, plant)
    # time between commands [s], by the controller's settings or else by the plan
    cycle = float(getattr(driver.settings, "cycle", ready.plan.tick))
    if args.dry_run:
        name, driver = "mock", make_driver("mock", {"cycle": cycle}, ready.model.robot, plant)
    require_free(path)
    require_showable(targets)
    require_attended(driver.simulated, args.yes)
    clearances = _clearances(args, plan, ready.model)
    require_clear(ready, clearances)
    start = StartRules(approach=args.approach, clearances=clearances)
    watch, current = run_options.stop_limits(args, ready.model.robot)
    job = Job(ready.model.robot, ready.plan.trajectory, ready.limits, start, watch, current)
    speed = f"{100 * args.speed:g} % of the planned speed"
    facts = run_options.run_facts(args, name, path, speed=speed, takes=run_cost(ready.plan, cycle))
    if name == "mock" and not (args.plant or args.dry_run):
        facts["simulated arm"] = "robot file with each value off by up to its tolerance; see --plant"
    print(run_summary.before(ready, facts), file=sys.stderr)
    warn(ready.warnings)
    if not driver.simulated:
        make_driver(name, settings, ready.model.robot, plant).find()
        if not args.no_rehearsal:
            print("the controller answers; rehearsing on a simulated arm", file=sys.stderr)
            progress = start_progress(job.motion.duration)
            rehearse(job, ready.model, cycle, payload.name if payload else "", progress)
    if args.check:
        _print_expected(args, plan, payload)
    confirm(driver.simulated, args.yes)
    # Prepared before the loop, which has no time for it; the trajectory is stored at full speed.
    head = partial(
        run_head,
        name=path.stem,
        model=read_model(args.robot),
        driver=name,
        payload=payload,
        trajectory=plan_text(within(plan, ready.model.robot)),
        speed=f"{args.speed:g}",
    )

    def viewers() -> list[PipeSink]:
        return [*start_view(targets), *start_progress(job.motion.duration)]

    outcome, recorder = run_recorded(driver, job, path, head, viewers)
    weighs = "payload" in plan.details  # planned by `exidyn payload`
    verb = "info" if outcome.stop is not None else "payload" if weighs else "identify"
    advice = f"{verb} {shlex.quote(str(path))}{' --fit FIT' * (verb == 'payload')}"
    page = run_summary.after(outcome, args.full)
    return report_run(outcome, recorder, path, advice, page, run_summary.table(outcome), args.json)


def _print_expected(args: Namespace, plan: Plan, payload: KnownPayload | None) -> None:
    """Print what the motion will determine; a motion that is too poor for a fit may still be recorded."""
    bodies = [payload.known] if payload else []
    try:
        sentences = expected_fit([plan], read_model(args.robot), bodies, speed=args.speed).sentences
    except NotExcited as error:
        warn([f"--check: {error}"])
        return
    for sentence in sentences:
        print("\n".join(paragraph(sentence)), file=sys.stderr)


def _plant(
    args: Namespace, ready: CheckedPlan, payload: KnownPayload | None, run: str
) -> Callable[[], Plant]:
    """A function that makes the mock's arm, at the start of the motion."""

    def make() -> Plant:
        model = ready.model
        if args.plant:
            model = read_model(args.plant)
            if payload is not None and not model.payloads:
                model = model + Payload(payload.name, payload.known)
        elif not args.dry_run:
            model = as_built(model)
        start = ready.plan.trajectory.state_at(0.0).position
        seed = noise_seed(args.seed, run)
        return simulated_arm(model, start, seed=seed, payload=payload.name if payload else "")

    return make


def _clearances(args: Namespace, plan: Plan, model: Model) -> tuple[Clearance, ...]:
    """Clearances of the approach and the motion.

    A plan already avoids self-collision unless its file was edited, but obstacles may have been added to the
    robot file or cell file since.
    """
    surroundings = read_surroundings(sources_of(args.robot, args.cell))
    if not (args.approach or plan.edited or surroundings):
        return ()
    return read_clearances(args, model.robot)
