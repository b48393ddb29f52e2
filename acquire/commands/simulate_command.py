"""exidyn simulate: simulate a planned motion in closed loop, or compare a simulation with a recording."""

import shlex
import time
from argparse import Namespace
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.errors import NeedsPayload, RobotError
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.model import Model
from exidyn.identification.pages.compared_document import compared_document, differs
from exidyn.identification.recordings.align import nearest
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.robot_file import model_text, read_model
from exidyn.identification.simulation.comparison import Comparison, compare
from exidyn.identification.text_table import digits, paragraph
from exidyn.trajectories.plans.plan import file_warnings, robot_differences
from exidyn.trajectories.plans.plan_file import read_plan

from ..arguments import options
from ..arguments.command import (
    Command,
    Group,
    Option,
    WrongUse,
    number,
    positive,
    print_warning,
    refuse_without,
    valid_if,
)
from ..arguments.run_options import PAYLOAD
from ..files.given_runs import ARM_HELP, read_arm, single_recording
from ..files.result_files import comparison_table
from ..run.arms import noise_seed
from ..run.simulated import simulated
from ..terminal.stopwatch import Stopwatch
from .result import Result

COMPARISON = (
    options.robot_option("for tables, which do not contain their robot"),
    Option(
        "--offset S", "added to the time of the simulation; default: where the positions agree best", number
    ),
    Option("--fit FIT", "fit.json that sets filters and noise floor", Path),
)


def compare_with(args: Namespace, path: Path, note: str = "") -> Result:
    """Compare the simulation at a path with the recording of --against; the note is on the simulation."""
    model = read_model(args.robot) if args.robot else None
    simulated, recorded = (single_recording(source, model) for source in (path, args.against))
    if simulated.name == recorded.name:
        simulated = replace(simulated, name=str(path))
    comparison = _compared(simulated, recorded, args.offset, read_fit(args.fit) if args.fit else None)
    following = _next_commands(args, path, simulated, recorded)
    table = comparison_table(comparison, [f"exidyn {command}" for command in following])
    return Result(compared_document(comparison, note), table, next=following if differs(comparison) else ())


def _compared(simulated: Recording, recorded: Recording, offset: float | None, fit: Fit | None) -> Comparison:
    """Compare both on one clock."""
    if offset is not None:
        return compare(simulated, recorded, offset, fit)
    alignment, repeat = nearest(simulated, recorded)
    comparison = compare(simulated, recorded, alignment.offset, fit)
    if not repeat:
        return comparison
    warning = (
        f"both agree as well {repeat:.2f} s further, since the motion repeats itself; "
        "state the offset of the clocks with --offset"
    )
    return replace(comparison, warnings=(*comparison.warnings, warning))


def _next_commands(args: Namespace, path: Path, simulated: Recording, recorded: Recording) -> list[str]:
    """Commands that diagnose the simulation's model with the recording."""
    run = shlex.quote(str(args.against))
    if args.robot:
        return [f"diagnose {run} --robot {shlex.quote(args.robot)}"]
    if model_text(simulated.model) == model_text(recorded.model):
        return [f"diagnose {run}"]
    model = shlex.quote(str(path.with_name(f"{path.stem}-model.toml")))
    return [f"export {shlex.quote(str(path))} --to toml -o {model}", f"diagnose {run} --robot {model}"]


FASTEST, SLOWEST = 1e-4, 0.1
"""Range of a controller's cycle [s]: current loops run every 0.1 ms, and no arm is commanded at 10 Hz."""


tick = valid_if(
    lambda value: FASTEST <= value <= SLOWEST,
    f"is not a cycle of a controller; it must be {FASTEST:g} to {SLOWEST:g} s",
    positive,
)


SIMULATION = (
    Option("--tick S", "sampling period", tick, 0.002),
    options.SPEED,
    options.seed_option("seed of the sensors' noise"),
)
BODIES = (Option("--payload NAME", "name of a payload of the model", default=""), *options.BODY)


@Command(
    "Simulate a planned motion in closed loop: the arm with all its effects, drives and\n"
    "sensors of industrial arms. Equal arguments give equal files. Or compare a simulation\n"
    "with a recording of the same motion: where they differ, and by how much.",
    (
        "exidyn simulate exidyn-fit/fit.json trajectory.toml -o sim.mcap",
        "exidyn simulate kr270 trajectory.toml --mass 175 --com 0.05 0.03 -0.22 -o loaded.mcap",
        "exidyn simulate sim.mcap --against real.mcap",
        "exidyn simulate mujoco.csv --against real.mcap --robot robot.toml --json compared.json",
    ),
    (
        Option("arm ARM", f"{ARM_HELP}; with --against alone the simulation (.mcap, .csv)"),
        Option("plan [TRAJECTORY]", options.PLAN.meaning, Path),
        options.output_option("FILE", Path("sim.mcap")),
        options.JSON,
        options.FULL,
        *SIMULATION,
        Group("payload on the flange: one of the model, or another", BODIES),
        Group(
            "compare the simulation with a recording",
            (Option("--against RUN", "recording of the real arm, or another run", Path), *COMPARISON),
        ),
    ),
)
def simulate_command(args: Namespace) -> Result:
    """Simulate and write the recording, or compare a simulation with a recording, or both."""
    if args.against is None:
        refuse_without("--against RUN", args, COMPARISON)
        if args.plan is None:
            raise WrongUse("give TRAJECTORY to simulate it, or --against RUN to compare a simulation with it")
        return _simulated(args)
    if args.plan is None:
        refuse_without("TRAJECTORY", args, [*SIMULATION, *BODIES])
        return compare_with(args, Path(args.arm))
    simulation = _simulated(args)
    return replace(compare_with(args, args.output, str(simulation.page)), written=simulation.written)


def _simulated(args: Namespace) -> Result:
    """Simulate the motion, and write the recording."""
    options.require_file(args.output, "--output", [args.arm, args.plan, args.against])
    arm, plan = read_arm(args.arm), read_plan(args.plan)
    nominal, payload = _carrying(args, arm)
    if plan.joints == arm.robot.joints:
        for sentence in [*file_warnings(plan, arm.robot), *robot_differences(plan, arm.robot)]:
            print_warning(sentence)
    began, run = time.perf_counter(), args.output.stem
    with Stopwatch() as progress:
        recording = simulated(
            arm, plan, nominal, payload, speed=args.speed, tick=args.tick, seed=noise_seed(args.seed, run),
            name=run, watched=progress.over,
        )  # fmt: skip
    seconds = time.perf_counter() - began
    write_recording(recording, args.output)
    table = _table(recording, seconds) | {"written": str(args.output)}
    following = [f"simulate {shlex.quote(str(args.output))} --against RUN"] if args.against is None else []
    return Result(_summary(recording, seconds), table, [args.output], next=following)


def _carrying(args: Namespace, arm: Model) -> tuple[Model, KnownPayload | None]:
    """The arm with its payload, and the payload that the recording states."""
    numbers = {name: getattr(args, name) for name in ("mass", "com", "inertia") if getattr(args, name)}
    if numbers and ("mass" not in numbers or args.payload):
        raise NeedsPayload("payload: give --mass [kg], or --payload with a name of the model, not both")
    names = arm.payloads
    if numbers:
        body = Payload(PAYLOAD, known_parameters(**numbers))
        others = tuple(effect for effect in arm.effects if effect is not names.get(PAYLOAD))
        stated = {
            name: prior for name, prior in arm.stated.items() if name in replace(arm, effects=others).names
        }
        return replace(arm, effects=(*others, body), stated=stated), KnownPayload(PAYLOAD, body.known)
    if not args.payload:
        return arm, None
    if args.payload not in names:
        raise RobotError(
            f"{arm.robot.name}: no payload '{args.payload}'. Payloads of the model: "
            f"{', '.join(names) or 'none'}"
        )
    return arm, KnownPayload(args.payload, names[args.payload].known)


def _summary(recording: Recording, seconds: float) -> str:
    """Duration, speed of the simulation, and largest deviations from the commands."""
    joints, units = recording.robot.joints, recording.robot.units("rad")
    deviations = zip(joints, _largest_deviations(recording), units, strict=True)
    text = ", ".join(f"{joint} {digits(deviation)} {unit}" for joint, deviation, unit in deviations)
    factor = recording.duration / seconds
    return (
        f"{recording.robot.name}: {recording.duration:.3f} s simulated in {seconds:.2f} s, "
        f"{digits(factor)} times real time\n"
        + "\n".join(paragraph(f"largest deviation from the command: {text}", "  ", ""))
    )


def _table(recording: Recording, seconds: float) -> dict[str, Any]:
    """The summary of a simulation for JSON."""
    return {
        "exidyn_simulation": 1,
        "name": recording.name,
        "robot": recording.robot.name,
        "joints": list(recording.robot.joints),
        "units": recording.robot.units("rad"),
        "duration": recording.duration,
        "seconds": seconds,
        "farthest_from_command": _largest_deviations(recording),
        "settings": dict(recording.settings),
    }


def _largest_deviations(recording: Recording) -> np.ndarray:
    """Largest deviation of each joint from its command, shape (n,) [rad] or [m]."""
    signals = recording.signals
    return np.abs(signals["position"].values - signals["command"].values).max(axis=0)
