"""Example: the files that a person with an arm brings, of a simulated one."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import as_built, simulate
from exidyn.identification.text_table import table
from exidyn.trajectories.random_motion import random_fourier

from .example_arm import NOMINAL, TRUTH, ExampleArm, Step

LOG = "log.csv"
FILES = (NOMINAL, LOG, TRUTH)
"""What is written, and not over a person's own."""
RATE, SECONDS = 250.0, 20.0
"""Samples a second [Hz] and length [s] of the log."""


@dataclass(frozen=True)
class ArmWithLog(ExampleArm):
    """An arm with a log of a motion that no planner chose, in degrees and amperes."""

    def files(self) -> Mapping[str, str]:
        """Robot files, name -> text; no payload belongs to this arm."""
        return {name: text for name, text in super().files().items() if name in FILES}

    def write(self, folder: Path) -> None:
        """Write robot files and log into a folder."""
        super().write(folder)
        motion = random_fourier(self.nominal.robot.limits, SECONDS).at(np.arange(0.0, SECONDS, 1.0 / RATE))
        truth = self.truth
        run = simulate(truth, truth.nominal_values, truth.robot.drive_gain, motion, self.nominal)
        position, current = run.signals["position"], run.signals["current"]
        rows = np.column_stack([position.time, np.degrees(position.values), current.values])
        joints = range(1, truth.robot.dof + 1)
        names = ",".join(["t", *(f"{letter}{joint}" for letter in "qi" for joint in joints)])
        np.savetxt(folder / LOG, rows, "%.6f", ",", header=names, comments="")


def arm() -> ExampleArm:
    """A collaborative arm as built, and as its maker states it."""
    nominal = read_model("cobot")
    return ArmWithLog(as_built(nominal), nominal)


def steps(_folder: Path, _length: float, _search: float) -> list[Step]:
    """None: they are a person's."""
    return []


def outcome(folder: Path) -> str:
    """What each file is."""
    rows = [
        [str(folder / NOMINAL), "the arm's nominal values, as a maker states them"],
        [str(folder / LOG), "a log of it: time [s], positions [degrees], motor currents [A]"],
        [str(folder / TRUTH), "what the simulated arm really is, to compare with"],
    ]
    return "\n".join(table(["file", "what it is"], rows, left=(0, 1)))
