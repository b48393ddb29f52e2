"""The tutorial in small, of an arm of two joints with a spring: plan, record, identify, diagnose.

A test run does it once, by the commands; tests of commands, pages, views and exports read what they wrote.
"""

from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path

import pytest

from exidyn.acquire.commands.example_command import run
from exidyn.acquire.examples.example_runs import ExampleArm, excited, recorded, step
from exidyn.identification.effects import Prior

from .plans.small_search import make_small
from .small import small_diagnosis

PRINTED = "printed.txt"
"""File of what the commands print."""
SECONDS = 11.2
"""Duration of each motion [s]."""
SMALL = "--tick", "0.004", "--harmonics", "2", "--period", "4"
"""Options of a search that takes a moment."""
STIFFNESS = 6.0
"""Of the spring at the elbow, which the nominal model lacks [N m/rad]."""


def arm() -> ExampleArm:
    """The arm of small_diagnosis: its truth has the spring, its nominal model has not."""
    stated = small_diagnosis.TRUE | {"Ks2": STIFFNESS, "Ts2": 0.0}
    plant = small_diagnosis.PLANT
    nominal = small_diagnosis.nominal_model()
    truth = replace(plant, stated={name: Prior(value) for name, value in stated.items()})
    return ExampleArm(replace(truth, robot=nominal.robot), nominal)


def write_tutorial(folder: Path) -> None:
    """Run every step of it in a folder."""
    arm().write(folder)
    robot, runs = folder / "robot.toml", (folder / "run.mcap", "--validate", folder / "other.mcap")
    steps = [
        excited(folder, "trajectory", SECONDS, None, *SMALL, least=True),
        excited(folder, "other", SECONDS, None, *SMALL, "--seed", "7", least=True),
        recorded(folder, "run", "trajectory", 1),
        recorded(folder, "other", "other", 2),
        step("identify", *runs, "--output", folder / "fit"),
        step("diagnose", *runs, "--robot", robot, "--output", folder / "diagnosis"),
    ]
    with pytest.MonkeyPatch.context() as patched, open(folder / PRINTED, "w") as out, redirect_stdout(out):
        make_small(patched)
        run(steps)
