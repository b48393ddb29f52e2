"""The tutorial in small: an arm of two joints with a spring is planned for, recorded, identified and diagnosed.

A test run does it once, by the commands; tests of commands, pages, views and exports read what they wrote.
"""

from dataclasses import replace
from pathlib import Path

from exidyn.acquire.commands.example_command import run
from exidyn.acquire.examples.example_arm import ExampleArm, excited, recorded, step
from exidyn.identification.effects import Prior

from .small import small_diagnosis

SECONDS = 8.0
"""Duration of each motion [s]."""
SEARCH = "--harmonics", "2", "--period", "4", "--starts", "1", "--tick", "0.004"
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
    run(
        [
            excited(folder, "trajectory", SECONDS, None, *SEARCH, least=True),
            excited(folder, "other", SECONDS, None, *SEARCH, "--seed", "7", least=True),
            recorded(folder, "run", "trajectory", 1),
            recorded(folder, "other", "other", 2),
            step("identify", *runs, "--output", folder / "fit"),
            step("diagnose", robot, *runs, "--output", folder / "diagnosis"),
        ]
    )
