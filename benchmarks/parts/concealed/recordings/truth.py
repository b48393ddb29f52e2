"""Truth files of concealed cases, which only the scorer reads."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..robots.robot import Robot
from .record import FILTER_HZ, Run, low_pass, rms
from .write import plain


def truth_of(robot: Robot, effects: list[dict[str, Any]], validate: Run) -> dict[str, Any]:
    """What is concealed in a robot, and the noise floor of the run held out."""
    machine = robot.machine
    return {
        "robot": robot.arm.name,
        "effects": effects,
        "noise_floor": rms(validate.noise),
        "noise_floor_filtered": rms(low_pass(validate.noise)),
        "noise_filter_hz": FILTER_HZ,
        "torque_range": 2.0 * robot.peak,
        "inertial_tolerance": robot.prior.inertial_tolerance,
        "plant": {
            "gain": robot.recorder.gain,
            "rotor_inertia": np.diag(machine.rotor),
            "viscous": np.diag(machine.friction.viscous),
            "coulomb": machine.friction.coulomb,
            "offset": machine.offset,
            "gravity": machine.body.gravity,
        },
    }


def write_truth(folder: Path, name: str, truth: dict[str, Any]) -> None:
    """Write it where the code under test does not look."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.json").write_text(json.dumps({"name": name, **truth}, indent=1, default=plain) + "\n")


def truth_table(folder: Path, name: str) -> dict[str, Any]:
    """Read a truth file."""
    truth: dict[str, Any] = json.loads((folder / f"{name}.json").read_text())
    return truth
