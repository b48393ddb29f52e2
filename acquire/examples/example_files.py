"""Example: files of a simulated arm such as a person with an arm has."""

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
"""Written files, which do not overwrite existing ones."""
RATE, SECONDS = 250.0, 20.0
"""Sampling rate [Hz] and duration [s] of the log."""


@dataclass(frozen=True)
class ArmWithLog(ExampleArm):
    """An arm with a log of an unplanned motion, in degrees and amperes."""

    def files(self) -> Mapping[str, str]:
        """Robot files, name -> text; this arm has no payload."""
        return {name: text for name, text in super().files().items() if name in FILES}

    def write(self, folder: Path) -> None:
        """Write the robot files and the log into a folder."""
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
    """A collaborative arm as built, and with the manufacturer's values."""
    nominal = read_model("cobot")
    return ArmWithLog(as_built(nominal), nominal)


def steps(_folder: Path, _length: float, _search: float | None) -> list[Step]:
    """No steps: the user runs the commands."""
    return []


def outcome(folder: Path) -> str:
    """Table of the files and their contents."""
    rows = [
        [str(folder / NOMINAL), "nominal values of the arm, as a manufacturer states them"],
        [str(folder / LOG), "log of the arm: time [s], positions [degrees], motor currents [A]"],
        [str(folder / TRUTH), "true values of the simulated arm, for comparison"],
    ]
    return "\n".join(table(["file", "content"], rows, left=(0, 1)))
