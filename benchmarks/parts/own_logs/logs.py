"""Logs to begin from: public recordings of real arms and a simulated one, with what is known of each."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np

from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.robot_files.robot_text import urdf_text

from .arms import fourier
from .sets import SETS, Known, RealSet


@dataclass(frozen=True)
class Samples:
    """A run in SI: time (t,), the rest (t, n); velocity is None where it was not recorded."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray | None
    effort: np.ndarray
    joints: tuple[str, ...]
    robot: str
    gain: np.ndarray | None

    @property
    def dof(self) -> int:
        """Number of joints."""
        return self.position.shape[1]


@dataclass(frozen=True)
class Log:
    """A log."""

    name: str  # In the tables
    # Writes it into a folder; returns the log, the robot's file, and what is true
    make: Callable[[Path], tuple[Path, Path, Known]]


def public() -> list[Log]:
    """One run of each public set."""
    sets = [data for data in SETS if data.path.exists() and not data.drive.startswith("[drive]\ngain")]
    return [Log(f"{data.folder}/{data.runs[0]}", partial(_copied, data)) for data in sets]


def _copied(data: RealSet, folder: Path) -> tuple[Path, Path, Known]:
    return *data.copy(data.runs[0], folder), data.known(data.runs[0])


@cache
def recorded(folder: str) -> Samples:
    """The first run of a data set, in SI."""
    data = next(data for data in SETS if data.folder == folder)
    table, known = data.table(data.runs[0]), data.known(data.runs[0])
    columns = {name: table.values[:, place] for place, name in enumerate(table.names)}
    position, column = (
        np.column_stack([columns[name] for name in known.columns[signal]])
        for signal in ("position", data.effort)
    )
    speeds = [name.replace("q", "dq") for name in known.columns["position"]]
    velocity = np.column_stack([columns[name] for name in speeds]) if known.velocity else None
    arm = data.path / data.robot
    return Samples(
        columns["t"], position, velocity, column, read_model(arm).robot.joints, arm.read_text(), data.gain
    )


@cache
def simulated() -> Samples:
    """Half a minute of the built-in cobot at 500 Hz: encoders of 19 bits, 2 % noise of current, friction."""
    model = read_model("cobot")
    rng, n = np.random.default_rng(3), model.robot.dof
    time = np.arange(15000) / 500.0
    middle = [0.0, -1.5, 0.5, -1.0, 0.5, 0.0]
    motion = fourier(middle, time, 3, 0.35)
    rng.normal(size=(2, n, 5))  # the numbers of that motion
    position = motion.position
    current = model.torque(model.loaded(motion), model.nominal_values) / model.robot.drive_gain
    current += 0.02 * current.std(axis=0) * rng.normal(size=current.shape)
    step = 2 * np.pi / 2**19
    position = np.round(position / step) * step
    gain = model.robot.drive_gain
    return Samples(time, position, motion.velocity, current, model.robot.joints, urdf_text(model), gain)
