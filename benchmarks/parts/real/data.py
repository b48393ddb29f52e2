"""The public recordings of real arms: which files train, which are held out, and the figures to beat.

Nothing of them is in the repository. Their folder is EXIDYN_DATA, by default `../shared/data` beside the
checkout; its READMEs hold sources, licences and how the yardsticks were made.
"""

import os
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identification.model import Model
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal
from exidyn.identification.robot_files.robot_file import read_model

FOLDER = Path(os.environ.get("EXIDYN_DATA", Path(__file__).parents[3] / "../shared/data"))

DE_LUCA = np.array([14.87, 13.26, 11.13, 10.62, 11.03, 11.47])
REPOSITORY = np.array([10.0, 10.70, 8.46, 9.00, 9.48, 10.12])
"""Two published sets of the UR10e's drive gains [N m/A]."""
PUBLISHED = np.abs(DE_LUCA - REPOSITORY) / np.sqrt(2.0) / DE_LUCA
"""Relative standard deviation of one such set, by the difference of the two [-]."""

LOADED = (("id_ur-20_02_19_14harm50secLoad", 2.805), ("id_ur-20_01_13-load_2600", 2.6))
"""Runs of the UR10e with a body on the flange, and its mass [kg]."""

KR300_TURNS = np.array([256.857, 267.429, 252.333, 221.0, 239.619, 154.323])
"""Motor turns per joint turn of the KR300; its torques are the motors'."""


@dataclass(frozen=True, eq=False)
class DataSet:
    """One arm's recordings, split as in its README."""

    key: str  # Name in the figures
    urdf: str  # Path of the robot's description in the folder
    train: tuple[str, ...]  # Names of the runs to fit
    held_out: tuple[str, ...]  # Names of the runs that are only predicted
    yardstick: np.ndarray  # Relative residual of the README's plain least squares, a row a held-out run [-]
    rate: float  # Sample rate [Hz]
    cutoff: float  # Low-pass through which the README compares torques [Hz]
    moving: float  # Low-passed speed above which the README counts a sample of a joint [rad/s]
    weighed: bool = True  # Whether the description holds inertias that can be trusted
    drives: dict[str, Any] = field(default_factory=dict)  # Fields of `Robot` that it does not state
    options: dict[str, Any] = field(default_factory=dict)  # Of the importer

    @property
    def filtering(self) -> Filtering:
        """The README's torque band; positions an octave wider, so that the band is the torque filter's.

        From which speed on a joint slides is left to `prepare`.
        """
        return Filtering(rate=self.rate, position_cutoff=2 * self.cutoff, torque_cutoff=self.cutoff)

    def model(self) -> Model:
        """Rigid body, rotors, viscous and Coulomb friction, offset: what a bare URDF is read as."""
        model = read_model(FOLDER / self.urdf)
        return replace(model, robot=replace(model.robot, **self.drives))

    def run(self, name: str, payload: KnownPayload | None = None) -> Recording:
        """One recording; "traj1[:2/3]" and "traj1[2/3:]" are the two parts of a single file."""
        stem, _, part = name.partition("[")
        file = (FOLDER / self.urdf).parent / f"{stem}.csv.gz"
        run = import_source(file, self.model(), payload=payload, **self.options)[0]
        return piece(run, *{"": (0, 3), ":2/3]": (0, 2), "2/3:]": (2, 3)}[part], 3, name)


def piece(run: Recording, first: int, stop: int, parts: int, name: str) -> Recording:
    """From `first` to `stop` of equal parts of a recording, time counted from its own beginning."""
    start, end = run.duration * first / parts, run.duration * stop / parts
    signals = {}
    for key, signal in run.signals.items():
        inside = (signal.time >= start) & ((signal.time < end) | (stop == parts))
        signals[key] = Signal(signal.time[inside] - signal.time[inside][0], signal.values[inside])
    return replace(run, name=name, signals=signals, host_time=None)


def thirds(run: Recording) -> list[Recording]:
    """A recording cut into three."""
    return [piece(run, k, k + 1, 3, f"{run.name} part {k + 1}") for k in range(3)]


UR10E = DataSet(
    key="ur10e", urdf="ur10e_mamedov/ur10e.urdf", rate=100.0, cutoff=8.0, moving=0.03,
    train=(
        "id_ur-20_02_05-20sec_12harm", "id_ur-20_02_06-20sec_10harm", "id_ur-20_02_10-30sec_12harm",
        "id_ur-20_02_12-40sec_12harm", "id_ur-20_02_19_15harm50sec",
    ),
    held_out=("id_ur-20_02_12-50sec_12harm", "id_ur-20_02_19_14harm50sec", "val_ur-20_01_17-ptp_10_points"),
    yardstick=np.array([
        [0.053, 0.043, 0.038, 0.034, 0.045, 0.035],
        [0.062, 0.033, 0.038, 0.035, 0.053, 0.044],
        [0.081, 0.038, 0.028, 0.032, 0.060, 0.051],
    ]),
    drives={"drive_gain": DE_LUCA, "drive_gain_tolerance": PUBLISHED},
)  # fmt: skip
KR300 = DataSet(
    key="kr300", urdf="kuka_kr300_weigand/kr300.urdf", rate=250.0, cutoff=10.0, moving=0.01,
    train=("2020-10-21_A", "2020-10-21_C"),
    held_out=("2020-10-21_B", "2020-10-16_A", "2020-10-19_B", "2020-10-19_C"),
    yardstick=np.array([
        [0.069, 0.063, 0.038, 0.186, 0.080, 0.168],
        [0.082, 0.068, 0.039, 0.200, 0.043, 0.078],
        [0.098, 0.063, 0.036, 0.225, 0.093, 0.149],
        [0.090, 0.052, 0.038, 0.127, 0.068, 0.086],
    ]),
    drives={"gear_ratio": KR300_TURNS}, options={"motor_side": ("torque",)},
)  # fmt: skip
PANDA = DataSet(
    key="panda", urdf="panda_gaz/panda.urdf", rate=1000.0, cutoff=8.0, moving=0.02,
    train=("traj1[:2/3]",), held_out=("traj1[2/3:]",),
    yardstick=np.array([[0.067, 0.012, 0.024, 0.010, 0.068, 0.027, 0.153]]),
    weighed=False,  # 1 kg a link, to have something there
)  # fmt: skip
