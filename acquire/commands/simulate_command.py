"""exidyn simulate: a planned motion in closed loop on a simulated arm, as a recording."""

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identify.effects import Payload, known_parameters
from exidyn.identify.errors import NeedsPayload, RobotError
from exidyn.identify.model import Model
from exidyn.identify.recordings.mcap.mcap_file import write_recording
from exidyn.identify.recordings.recording import KnownPayload, Recording
from exidyn.identify.simulation.plant import Transmission
from exidyn.identify.text_table import digits, paragraph
from exidyn.trajectories.plans.plan import robot_differences
from exidyn.trajectories.plans.plan_file import read_plan

from ..arguments.common import (
    add_body,
    add_plan,
    add_seed,
    any_number,
    command_parser,
    complaint,
    percent,
    positive,
)
from ..arguments.outputs import add_json, add_output, require_file, require_json
from ..files.arm_file import ARM_HELP, read_arm
from ..run.simulated import simulated
from ..terminal.json_output import hand_over, json_text, plain, print_written
from ..terminal.stopwatch import with_bar

FASTEST, SLOWEST = 1e-4, 0.1
"""Cycles [s] of controllers: current loops close every 0.1 ms, and no arm is led ten times a second."""
BODY = "L"
"""What a payload that is given by its mass is called."""
EXAMPLES = (
    "exidyn simulate exidyn-fit/fit.json trajectory.toml -o sim.mcap",
    "exidyn simulate kr270 trajectory.toml --mass 175 --com 0.05 0.03 -0.22 -o loaded.mcap",
    "exidyn simulate robot.toml trajectory.toml --stiffness 2e5 3e5 1e5 4e4 3e4 2e4 --backlash 1e-4",
)


def main(arguments: Sequence[str]) -> int:
    """Simulate, write, and print how fast that was."""
    given = parser().parse_args(arguments)
    require_json(given.json)
    require_file(given.output, "--output", [given.arm, given.plan])
    arm, plan = read_arm(given.arm), read_plan(given.plan)
    nominal, carried = _carrying(given, arm)
    for difference in robot_differences(plan, arm.robot) if plan.joints == arm.robot.joints else ():
        print(complaint(f"exidyn: warning: {difference}"), file=sys.stderr)
    began = time.perf_counter()
    recording = simulated(
        arm, plan, nominal, carried, _transmission(given, arm), speed=given.speed, tick=given.tick,
        seed=given.seed, exact=given.exact, name=given.name or given.output.stem, watched=with_bar,
    )  # fmt: skip
    taken = time.perf_counter() - began
    write_recording(recording, given.output)
    table = _table(recording, taken) | {"written": str(given.output)}
    hand_over(_summary(recording, taken), json_text(table), given.json)
    print_written(given.output)
    return 0


def _carrying(given: argparse.Namespace, arm: Model) -> tuple[Model, KnownPayload | None]:
    """The arm with what hangs on its flange, and what the recording states about it."""
    numbers = {name: getattr(given, name) for name in ("mass", "com", "inertia") if getattr(given, name)}
    if numbers and ("mass" not in numbers or given.payload):
        raise NeedsPayload(
            "what hangs on the flange: give --mass [kg], or the --payload of the model, not both"
        )
    names = arm.payloads
    if numbers:
        body = Payload(BODY, known_parameters(**numbers))
        others = tuple(effect for effect in arm.effects if effect is not names.get(BODY))
        stated = {
            name: prior for name, prior in arm.stated.items() if name in replace(arm, effects=others).names
        }
        return replace(arm, effects=(*others, body), stated=stated), KnownPayload(BODY, body.known)
    if not given.payload:
        return arm, None
    if given.payload not in names:
        raise RobotError(
            f"{arm.robot.name}: no payload '{given.payload}'. Payloads of the model: "
            f"{', '.join(names) or 'none'}"
        )
    return arm, KnownPayload(given.payload, names[given.payload].known)


def _transmission(given: argparse.Namespace, arm: Model) -> Transmission:
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
    return plain(
        {
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
    )


def _missed(recording: Recording) -> np.ndarray:
    """How far each joint was from its command at most, shape (n,) [rad, m]."""
    signals = recording.signals
    return np.abs(signals["position"].values - signals["command"].values).max(axis=0)


def _units(recording: Recording) -> list[str]:
    return ["rad" if revolute else "m" for revolute in recording.robot.revolute]


def parser() -> argparse.ArgumentParser:
    """What `exidyn simulate` takes."""
    found = command_parser(
        "simulate",
        "Simulate a planned motion in closed loop: the arm with all its effects, drives and\n"
        "sensors as industrial arms have them. The same arguments give the same file.",
        EXAMPLES,
    )
    found.add_argument("arm", metavar="ARM", help=ARM_HELP)
    add_plan(found)
    add_output(found, "FILE", Path("sim.mcap"))
    add_json(found)
    found.add_argument("--name", metavar="NAME", help="what to call the run; default: the name of the file")
    found.add_argument(
        "--tick",
        type=_tick,
        default=0.002,
        metavar="S",
        help="from sample to sample; default: %(default)s",
    )
    found.add_argument(
        "--speed", type=percent, default=1.0, metavar="PERCENT", help="of the planned one; default: 100"
    )
    add_seed(found, "of the sensors' noise")
    found.add_argument("--exact", action="store_true", help="sensors without noise and steps")
    flange = found.add_argument_group("what hangs on the flange: a payload of the model, or a body")
    flange.add_argument("--payload", default="", metavar="NAME", help="of a payload of the model")
    add_body(flange)
    _gears(found.add_argument_group("gears that give way: one number, or one a joint, seen from the joint"))
    return found


def _tick(text: str) -> float:
    if not FASTEST <= positive(text) <= SLOWEST:
        raise argparse.ArgumentTypeError(f"{text} is no cycle of a controller; {FASTEST:g} to {SLOWEST:g} s")
    return positive(text)


def _gears(group: argparse._ArgumentGroup) -> None:
    for name, default, unit, meaning in (
        ("--stiffness", np.inf, "NM/RAD", "inf for rigid, the default"),
        ("--damping", 0.0, "NMS/RAD", "of the same spring"),
        ("--backlash", 0.0, "RAD", "width of the play"),
    ):
        group.add_argument(name, type=any_number, nargs="+", default=[default], metavar=unit, help=meaning)
