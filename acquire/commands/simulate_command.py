"""exidyn simulate: a planned motion in closed loop on a simulated arm, as a recording."""

import time
from argparse import Namespace
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.errors import NeedsPayload, RobotError
from exidyn.identification.model import Model
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.simulation.plant import Transmission
from exidyn.identification.text_table import digits, paragraph
from exidyn.trajectories.plans.plan import robot_differences
from exidyn.trajectories.plans.plan_file import read_plan
from exidyn.trajectories.plans.plan_limits import file_warnings

from ..arguments.command import Command, Group, Option, any_number, positive, print_warning, valid_if
from ..arguments.options import (
    BODY,
    JSON,
    NAME,
    PLAN,
    SPEED,
    output_option,
    require_file,
    require_json,
    seed_option,
)
from ..arguments.run_options import PAYLOAD
from ..files.given_runs import ARM_HELP, read_arm
from ..run.arms import noise_seed
from ..run.simulated import simulated
from ..terminal.json_output import hand_over, json_text, print_written
from ..terminal.stopwatch import with_bar

FASTEST, SLOWEST = 1e-4, 0.1
"""Cycles [s] of controllers: current loops close every 0.1 ms, and no arm is led ten times a second."""


tick = valid_if(
    lambda value: FASTEST <= value <= SLOWEST,
    f"is no cycle of a controller; {FASTEST:g} to {SLOWEST:g} s",
    positive,
)


@Command(
    "Simulate a planned motion in closed loop: the arm with all its effects, drives and\n"
    "sensors as industrial arms have them. The same arguments give the same file.",
    (
        "exidyn simulate exidyn-fit/fit.json trajectory.toml -o sim.mcap",
        "exidyn simulate kr270 trajectory.toml --mass 175 --com 0.05 0.03 -0.22 -o loaded.mcap",
        "exidyn simulate robot.toml trajectory.toml --stiffness 2e5 3e5 1e5 4e4 3e4 2e4 --backlash 1e-4",
    ),
    (
        Option("arm ARM", ARM_HELP),
        PLAN,
        output_option("FILE", Path("sim.mcap")),
        JSON,
        NAME,
        Option("--tick S", "from sample to sample", tick, 0.002),
        SPEED,
        seed_option("of the sensors' noise"),
        Option("--exact", "sensors without noise and steps"),
        Group(
            "what hangs on the flange: a payload of the model, or a body",
            (Option("--payload NAME", "of a payload of the model", default=""), *BODY),
        ),
        Group(
            "gears that give way, beside those of the arm: one number, or one a joint, seen from the joint",
            (
                Option("--stiffness NM/RAD...", "inf for rigid, the default", any_number, [np.inf]),
                Option("--damping NMS/RAD...", "of the same spring", any_number, [0.0]),
                Option("--backlash RAD...", "width of the play", any_number, [0.0]),
            ),
        ),
    ),
)
def simulate_command(given: Namespace) -> None:
    """Simulate, write, and print how fast that was."""
    require_json(given.json)
    require_file(given.output, "--output", [given.arm, given.plan])
    arm, plan = read_arm(given.arm), read_plan(given.plan)
    nominal, carried = _carrying(given, arm)
    if plan.joints == arm.robot.joints:
        for sentence in [*file_warnings(plan, arm.robot), *robot_differences(plan, arm.robot)]:
            print_warning(sentence)
    began, run = time.perf_counter(), given.name or given.output.stem
    recording = simulated(
        arm, plan, nominal, carried, _transmission(given, arm), speed=given.speed, tick=given.tick,
        seed=noise_seed(given.seed, run), exact=given.exact, name=run, watched=with_bar,
    )  # fmt: skip
    taken = time.perf_counter() - began
    write_recording(recording, given.output)
    table = _table(recording, taken) | {"written": str(given.output)}
    hand_over(_summary(recording, taken), json_text(table), given.json)
    print_written(given.output)


def _carrying(given: Namespace, arm: Model) -> tuple[Model, KnownPayload | None]:
    """The arm with what hangs on its flange, and what the recording states about it."""
    numbers = {name: getattr(given, name) for name in ("mass", "com", "inertia") if getattr(given, name)}
    if numbers and ("mass" not in numbers or given.payload):
        raise NeedsPayload(
            "what hangs on the flange: give --mass [kg], or the --payload of the model, not both"
        )
    names = arm.payloads
    if numbers:
        body = Payload(PAYLOAD, known_parameters(**numbers))
        others = tuple(effect for effect in arm.effects if effect is not names.get(PAYLOAD))
        stated = {
            name: prior for name, prior in arm.stated.items() if name in replace(arm, effects=others).names
        }
        return replace(arm, effects=(*others, body), stated=stated), KnownPayload(PAYLOAD, body.known)
    if not given.payload:
        return arm, None
    if given.payload not in names:
        raise RobotError(
            f"{arm.robot.name}: no payload '{given.payload}'. Payloads of the model: "
            f"{', '.join(names) or 'none'}"
        )
    return arm, KnownPayload(given.payload, names[given.payload].known)


def _transmission(given: Namespace, arm: Model) -> Transmission:
    n = arm.robot.dof
    parts = []
    for name in ("stiffness", "damping", "backlash"):
        values = getattr(given, name)
        if len(values) not in (1, n):
            raise RobotError(
                f"--{name} has {len(values)} values; expected one, or one for each of the {n} joints"
            )
        parts.append(np.broadcast_to(np.array(values, float), (n,)))
    return Transmission(*parts)


def _summary(recording: Recording, taken: float) -> str:
    """Length, speed, and how far the arm was from its commands."""
    joints, missed, unit = recording.robot.joints, _missed(recording), _units(recording)
    far = ", ".join(f"{j} {digits(m)} {u}" for j, m, u in zip(joints, missed, unit, strict=True))
    factor = recording.duration / taken
    return (
        f"{recording.robot.name}: {recording.duration:.3f} s simulated in {taken:.2f} s, "
        f"{digits(factor)} times real time\n"
        + "\n".join(paragraph(f"farthest from its command: {far}", "  ", ""))
    )


def _table(recording: Recording, taken: float) -> dict[str, Any]:
    """The same in numbers."""
    return {
        "exidyn_simulation": 1,
        "name": recording.name,
        "robot": recording.robot.name,
        "joints": list(recording.robot.joints),
        "units": _units(recording),
        "duration": recording.duration,
        "seconds": taken,
        "farthest_from_command": _missed(recording),
        "settings": dict(recording.settings),
    }


def _missed(recording: Recording) -> np.ndarray:
    """How far each joint was from its command at most, shape (n,) [rad, m]."""
    signals = recording.signals
    return np.abs(signals["position"].values - signals["command"].values).max(axis=0)


def _units(recording: Recording) -> list[str]:
    return ["rad" if revolute else "m" for revolute in recording.robot.revolute]
