"""Logs to begin from: public recordings of real arms and a simulated one, with what is known of each."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np

from exidyn.identify.arm.motion import Motion
from exidyn.identify.recordings.importers import read_tables
from exidyn.identify.robot_files.robot_file import read_model
from exidyn.identify.robot_files.robot_text import urdf_text

from ..real.data import DE_LUCA, FOLDER, KR300_TURNS

DIRECT = """<robot name="motor">
<link name="stator"/>
<joint name="rotor" type="continuous">
<parent link="stator"/><child link="body"/><axis xyz="0 0 1"/><limit velocity="200" effort="10"/>
</joint>
<link name="body"><inertial>
<mass value="0.1"/><inertia ixx="2e-4" iyy="2e-4" izz="1.8e-4" ixy="0" ixz="0" iyz="0"/>
</inertial></link>
</robot>
"""
"""The motor of odrive_spin_slow without a gear: the one in its robot.toml is fictitious."""


@dataclass(frozen=True)
class Known:
    """What is true of a log.

    Attributes:
        time: Unit.
        position: Unit.
        velocity: Unit a second, "" without velocities.
        effort: "torque" of the joints, or "current" for anything that needs a gain.
        gain: Of the drives [N m per unit], shape (n,); None where nobody knows.
        columns: Names by signal in the order of the robot's joints, those that must be found.
    """

    time: str
    position: str
    velocity: str
    effort: str
    gain: np.ndarray | None
    columns: dict[str, list[str]]


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
    """A log.

    Attributes:
        name: In the tables.
        make: Writes it into a folder; returns the log, the robot's file, and what is true.
        fit: Whether the way goes on to a fit.
    """

    name: str
    make: Callable[[Path], tuple[Path, Path, Known]]
    fit: bool = True


SETS = {
    "ur10e_mamedov": ("ur10e.urdf", "id_*", "id_ur-20_02_05-20sec_12harm", "current", DE_LUCA),
    "kuka_kr300_weigand": ("kr300.urdf", "20*", "2020-10-21_A", "current", KR300_TURNS),
    "panda_gaz": ("panda.urdf", "traj1", "traj1", "torque", None),
    "staubli_tx40": ("tx40.urdf", "train", "train", "torque", None),
    "emps": ("robot.toml", "*", "train", "torque", None),
    "kscale_sts3215": ("robot_{}.toml", "m*", "m1168_l100_sin_sin_kp16", "current", np.array([0.53])),
    "dvrk_psm": ("psm.urdf", "*", "fourier_test2", "torque", None),
    "bam_xl330": ("pend.urdf", "kp*", "kp100_sin_sin", "current", np.array([0.0007])),
    "odrive_spin_slow": ("", "*_measured", "nocomp_4_measured", "current", None),
}
"""Folder -> robot file, runs that are looked at, the run that is fitted, effort, published gains."""
NO_TRUTH = ("pulses_truth",)


def public(every: bool) -> list[Log]:
    """The public data sets, one run of each or all."""
    logs = []
    for folder, (robot, pattern, fitted, effort, gain) in SETS.items():
        for path in sorted((FOLDER / folder).glob(f"{pattern}.csv.gz")):
            name = path.name.removesuffix(".csv.gz")
            if name in NO_TRUTH or not (every or name == fitted):
                continue
            arm = robot.format("_".join(name.split("_")[:2]))
            make = partial(_copied, path, FOLDER / folder / arm if arm else None, effort, gain)
            logs.append(Log(f"{folder}/{name}", make, name == fitted))
    return logs


def _copied(
    path: Path, robot: Path | None, effort: str, gain: np.ndarray | None, folder: Path
) -> tuple[Path, Path, Known]:
    log, arm = folder / path.name, folder / (f"arm{robot.suffix}" if robot else "arm.urdf")
    log.write_bytes(path.read_bytes())
    arm.write_text(robot.read_text() if robot else DIRECT)
    return log, arm, _known(path, effort, gain)


def _known(path: Path, effort: str, gain: np.ndarray | None) -> Known:
    names = read_tables(path)[0].names
    numbers = range(1, sum(name.startswith("q") and name[1:].isdigit() for name in names) + 1)
    column = "i" if "i1" in names else "tau"
    columns = {
        "time": ["t"],
        "position": [f"q{k}" for k in numbers],
        effort: [f"{column}{k}" for k in numbers],
    }
    if "dvrk" in str(path):  # whether its efforts are torques of the motor or of the joint nobody knows
        columns.pop(effort)
    unit = "m" if "emps" in str(path) else "rad"
    return Known("s", unit, unit if "dq1" in names else "", effort, gain, columns)


@cache
def recorded(folder: str) -> Samples:
    """The fitted run of a data set, in SI."""
    robot, _, fitted, effort, gain = SETS[folder]
    table = read_tables(FOLDER / folder / f"{fitted}.csv.gz")[0]
    known = _known(FOLDER / folder / f"{fitted}.csv.gz", effort, gain)
    position, column = (
        table.values[:, [table.names.index(name) for name in known.columns[signal]]]
        for signal in ("position", effort)
    )
    speeds = [name.replace("q", "dq") for name in known.columns["position"]]
    velocity = table.values[:, [table.names.index(name) for name in speeds]] if known.velocity else None
    arm = FOLDER / folder / robot
    joints = read_model(arm).robot.joints
    return Samples(table.values[:, 0], position, velocity, column, joints, arm.read_text(), gain)


@cache
def simulated() -> Samples:
    """Half a minute of the built-in cobot at 500 Hz: encoders of 19 bits, 2 % noise of current, friction."""
    model = read_model("cobot")
    rng, n = np.random.default_rng(3), model.robot.dof
    time = np.arange(15000) / 500.0
    rate = 2 * np.pi * np.arange(1, 6) / 10.0
    size = rng.normal(size=(2, n, len(rate))) * 0.35 / (1 + np.arange(len(rate)))
    middle = np.array([0.0, -1.5, 0.5, -1.0, 0.5, 0.0])
    sine, cosine = np.sin(time[:, None] * rate), np.cos(time[:, None] * rate)
    position = middle + sine @ size[0].T + cosine @ size[1].T
    velocity = cosine @ (size[0] * rate).T - sine @ (size[1] * rate).T
    acceleration = -sine @ (size[0] * rate**2).T - cosine @ (size[1] * rate**2).T
    motion = model.loaded(Motion.of(time, position, velocity, acceleration))
    current = model.torque(motion, model.nominal_values) / model.robot.drive_gain
    current += 0.02 * current.std(axis=0) * rng.normal(size=current.shape)
    step = 2 * np.pi / 2**19
    position = np.round(position / step) * step
    gain = model.robot.drive_gain
    return Samples(time, position, velocity, current, model.robot.joints, urdf_text(model), gain)
