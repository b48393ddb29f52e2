"""exidyn record: play a planned motion on a controller and record the run."""

import argparse
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import version
from pathlib import Path

import numpy as np
from exidyn.drivers import Driver, Info, Sample
from exidyn.drivers.driver import Plant
from exidyn.identify.effects import Payload, known_parameters
from exidyn.identify.errors import NeedsPayload
from exidyn.identify.geometry import read_geometry
from exidyn.identify.model import Model
from exidyn.identify.plant import typical_plant
from exidyn.identify.recording import KnownPayload
from exidyn.identify.robot_file import read_model
from exidyn.trajectories.clearances.clearance import Clearance
from exidyn.trajectories.clearances.self_collision import SelfCollision
from exidyn.trajectories.plans.plan_file import plan_text, read_plan

from . import run_summary
from .confirm import confirm, require_attended
from .controllers import make_driver, read_controller
from .exit_codes import DONE, STOPPED
from .json_output import hand_over, json_text, require_json
from .live.live_view import Targets, require_showable, start_view
from .progress import start_progress
from .record_arguments import parser as parser
from .run.before import Checked, checked
from .run.errors import NotAllowed
from .run.frames import END, text_frame
from .run.perform import Job, Outcome, perform
from .run.pipe_sink import PipeSink
from .run.realtime import realtime
from .run.recorder import part_of, require_free, start_recorder
from .run.rehearsal import rehearse
from .run.run_head import RunHead
from .run.start import StartRules
from .run.stop_requests import StopRequests
from .run.watch import WatchLimits

BODY = "L"
"""What the unknown parameters of the payload are called after."""


def main(arguments: Sequence[str]) -> int:
    """Check, rehearse, ask, run, record; 0 if the run came to its end."""
    given = parser().parse_args(arguments)
    payload = _payload(given)
    ready = checked(read_plan(given.plan), read_model(given.robot), given.speed, payload)
    name, settings = read_controller(given.controller, given.driver, given.set)
    if given.plant and name != "mock" and not given.dry_run:
        raise NotAllowed(f"--plant is an arm of the mock, and {name} moves a real one. Leave one of them out")
    plant = _plant(given, ready, payload)
    driver = make_driver(name, settings, ready.model.robot, plant)
    if given.dry_run:
        rehearsed = {"cycle": getattr(driver.settings, "cycle", ready.plan.tick)}
        name, driver = "mock", make_driver("mock", rehearsed, ready.model.robot, plant)
    path, targets = _free(given.output), Targets(given.view, given.serve, given.save)
    require_free(path)
    require_json(given.json)
    require_showable(targets)
    require_attended(driver.simulated, given.yes)
    job = _job(given, ready)
    print(run_summary.before(ready, _facts(given, name, path)), file=sys.stderr)
    _warn(ready.doubts)
    if not driver.simulated and not given.no_rehearsal:
        _rehearse(job, ready, driver, payload)
    confirm(driver.simulated, given.yes)
    # Read and written before the loop, which has no time for it; at full speed, as the file has it.
    explained = read_model(given.robot), plan_text(read_plan(given.plan))
    head = partial(_head, given, name, explained, payload, path)
    outcome = _record(targets, driver, job, path, head, given.json)
    return DONE if outcome.stop is None else STOPPED


def _payload(given: argparse.Namespace) -> KnownPayload | None:
    numbers = {n: getattr(given, n) for n in ("mass", "com", "inertia") if getattr(given, n) is not None}
    if not numbers:
        return None
    if "mass" not in numbers:
        raise NeedsPayload(f"{' and '.join(numbers)} given without --mass [kg]")
    return KnownPayload(BODY, known_parameters(**numbers))


def _plant(given: argparse.Namespace, ready: Checked, payload: KnownPayload | None) -> Callable[[], Plant]:
    """What makes the arm of the mock, standing where the motion begins."""

    def make() -> Plant:
        model = ready.model
        if given.plant:
            model = read_model(given.plant)
            if payload is not None and not any(isinstance(effect, Payload) for effect in model.effects):
                model = model + Payload(payload.name, payload.known)
        start = ready.plan.trajectory.state_at(0.0).position
        return typical_plant(model, start, seed=given.seed, payload=payload.name if payload else "")

    return make


def _job(given: argparse.Namespace, ready: Checked) -> Job:
    robot = ready.model.robot
    start = StartRules(approach=given.approach, clearances=_clearances(given, ready.model))
    watch = WatchLimits(tracking=float(np.radians(given.tracking)), temperature=given.temperature)
    current = None
    if given.current:
        if len(given.current) not in (1, robot.dof):
            raise NotAllowed(
                f"--current has {len(given.current)} values; expected one, or one for each of the "
                f"{robot.dof} joints"
            )
        current = np.broadcast_to(np.array(given.current), (robot.dof,))
    return Job(robot, ready.plan.trajectory, ready.limits, start, watch, current)


def _clearances(given: argparse.Namespace, model: Model) -> tuple[Clearance, ...]:
    """What the way to the motion must keep clear of; only an approach can come near anything."""
    geometry = (
        None if given.no_collision or not given.approach else read_geometry(given.robot, given.packages)
    )
    return () if geometry is None else (SelfCollision.of(model.robot, geometry),)


def _facts(given: argparse.Namespace, driver: str, path: Path) -> Mapping[str, str]:
    """What a person should know before saying yes, by name."""
    carried = f"{given.mass:g} kg" if given.mass else "nothing"
    return {
        "controller": driver,
        "speed": f"{100 * given.speed:g} % of the planned",
        "on the flange": carried,
        "recorded to": str(path),
    }


def _free(wanted: Path | None) -> Path:
    """Where to write; without a wish the first run.mcap, run-2.mcap, ... that is not there yet."""
    names = (Path(f"run-{number}.mcap" if number > 1 else "run.mcap") for number in range(1, 100_000))
    return wanted or next(p for p in names if not p.exists() and not part_of(p).exists())


def _rehearse(job: Job, ready: Checked, driver: Driver, payload: KnownPayload | None) -> None:
    print("rehearsing on a simulated arm", file=sys.stderr)
    cycle = getattr(driver.settings, "cycle", ready.plan.tick)
    rehearse(job, ready.model, cycle, payload.name if payload else "")


def _head(
    given: argparse.Namespace,
    driver: str,
    explained: tuple[Model, str],
    payload: KnownPayload | None,
    path: Path,
    info: Info,
    sample: Sample,
) -> bytes:
    """What explains the run by its model and its plan's text, once its first sample is there."""
    model, plan = explained
    settings = {
        "driver": driver,
        "cycle": f"{info.cycle:g} s",
        "clock": info.clock,
        "dead man": info.dead_man or "none",
        "speed": f"{given.speed:g}",
        "recorded": datetime.now(UTC).isoformat(timespec="seconds"),
        "exidyn": version("exidyn"),
        "note": given.note,
        **{f"driver {name}": text for name, text in info.settings.items()},
    }
    return RunHead(
        name=given.name or path.stem,
        model=model,
        signals=info.signals,
        epoch=sample.host_time,
        zero=sample.controller_time,
        trajectory=plan,
        payload=payload,
        settings={name: text for name, text in settings.items() if text},
        warnings=info.warnings,
    ).frame()


def _record(
    targets: Targets,
    driver: Driver,
    job: Job,
    path: Path,
    head: Callable[[Info, Sample], bytes],
    json_file: Path | None = None,
) -> Outcome:
    """Start who records and shows, run, and say how it went."""
    with ExitStack() as stack:
        # First in, last out: what is asked while the recorder finishes must not end it.
        asked = stack.enter_context(StopRequests())
        recorder = stack.enter_context(start_recorder(path, waits=not driver.in_real_time))
        others = [*start_view(targets), *start_progress(job.motion.duration)]
        sinks = [recorder, *(stack.enter_context(other) for other in others)]
        if driver.in_real_time:
            _warn(stack.enter_context(realtime()))
        outcome = perform(driver, job, sinks, head, asked.look, _say_doubts)
        for sink in sinks:
            sink.put(text_frame(END, run_summary.end(outcome)))
    table = run_summary.table(outcome) | {"written": str(path)}
    hand_over(run_summary.after(outcome), json_text(table), json_file)
    _say_where(recorder, path, outcome.stop is None)
    return outcome


def _say_doubts(info: Info) -> None:
    """What a person should know before drives are powered."""
    unguarded = "nothing is known to stop the arm by itself if this program dies"
    _warn((*info.warnings, *([] if info.dead_man else [unguarded])))


def _warn(doubts: Iterable[str]) -> None:
    for doubt in doubts:
        print(f"exidyn: warning: {doubt}", file=sys.stderr)


def _say_where(recorder: PipeSink, path: Path, whole: bool) -> None:
    if path.exists():
        more = "identify {} finds the dynamics in it" if whole else "info {} tells what happened"
        print(f"written: {path}; exidyn {more.format(path)}", file=sys.stderr)
    elif part_of(path).exists():
        print(
            f"exidyn: {recorder.failure or 'the recorder did not finish'}; what was written is in "
            f"{part_of(path)}, see exidyn recover",
            file=sys.stderr,
        )
