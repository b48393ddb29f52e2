"""Correct recordings: real arms cut to at most half a minute, and simulated arms with or without an effect."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from exidyn.identification.effects import JointSpring, LoadDependentFriction, Prior, StribeckFriction
from exidyn.identification.model import Model
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import simulate
from exidyn.trajectories.random_motion import random_fourier

from ..injected import effort
from ..real.data import FOLDER, KR300, UR10E

SECONDS = 24.0
"""Largest duration of a recording [s]."""
RATE = 130.0
"""Largest sampling rate [Hz]; faster recordings are averaged over samples."""


@dataclass(frozen=True, eq=False)
class Log:
    """A description and a recording of the arm: time (t,), position and effort (t, n)."""

    name: str
    arm: str  # recordings of one arm are calibrated together, or reported together
    model: Model
    run: Recording

    @property
    def time(self) -> np.ndarray:
        return self.run.signals["position"].time

    @property
    def position(self) -> np.ndarray:
        return self.run.signals["position"].values

    @property
    def effort(self) -> np.ndarray:
        return self.run.signals[effort(self.run)].values

    def having(
        self, position: np.ndarray | None = None, torque: np.ndarray | None = None, model: Model | None = None
    ) -> "Log":
        """This log with other positions, efforts or another description."""
        new = {"position": position, effort(self.run): torque}
        signals = {
            name: signal if new[name] is None else Signal(self.time, new[name])
            for name, signal in self.run.signals.items()
        }
        model = model or self.model
        return replace(self, model=model, run=replace(self.run, signals=signals, model=model))


def shortened(name: str, arm: str, model: Model, run: Recording) -> Log:
    """The first `SECONDS` at `RATE` at most, positions and efforts alone at the same times."""
    position = run.signals["position"]
    time = position.time
    values = {
        key: np.stack([np.interp(time, run.signals[key].time, column) for column in run.signals[key].values.T], 1)
        for key in ("position", effort(run))
    }
    step = max(round(1.0 / np.median(np.diff(time)) / RATE), 1)
    count = min(len(time), int(np.searchsorted(time, time[0] + SECONDS))) // step

    def mean(array: np.ndarray) -> np.ndarray:
        return array[: count * step].reshape(count, step, -1).mean(axis=1)

    stamps = mean(time[:, None])[:, 0]
    signals = {key: Signal(stamps - stamps[0], mean(array)) for key, array in values.items()}
    run = replace(run, name=name, signals=signals, model=model, host_time=None)
    return Log(name, arm, model, run)


REAL = {
    "baxter_left": ("left.urdf", ("train_random", "train_sin_xyz_8s_t2_tz_4t_r10", "test_square")),
    "kuka_lwr4": ("arm.urdf", ("meas_1", "meas_2", "meas_3")),
    "airbot_play": ("robot.toml", ("opt", "N7T25_5", "ga_N12T25")),
    "dvrk_psm": ("robot.toml", ("fourier_test", "fourier_test2", "fourier_test5")),
    "staubli_tx40": ("robot.toml", ("train",)),
    "panda_gaz": ("panda.urdf", ("traj1",)),
    "emps": ("robot.toml", ("train",)),
    "pendubot": ("robot.toml", ("h1",)),
}
"""Folder -> description and runs."""
SEPARATE = ("id_ur-20_02_05-20sec_12harm", "id_ur-20_02_10-30sec_12harm", "id_ur-20_02_12-40sec_12harm",
            "id_ur-20_02_19_15harm50sec")  # fmt: skip
HEAVY = ("2020-10-21_A", "2020-10-21_C", "2020-10-16_A", "2020-10-19_B")


def real() -> Iterator[Log]:
    """Recordings of real arms whose columns, units and signs are known to be right."""
    for data, names in ((UR10E, SEPARATE), (KR300, HEAVY)):
        for name in names:
            yield shortened(f"{data.key} {name[-12:]}", data.key, data.model(), data.run(name))
    for folder, (robot, names) in REAL.items():
        model = read_model(FOLDER / folder / robot)
        for name in names:
            run = import_source(FOLDER / folder / f"{name}.csv.gz", model)[0]
            yield shortened(f"{folder} {name[:12]}", folder, model, run)


def simulated() -> Iterator[Log]:
    """Recordings of built-in arms, with one effect that the description lacks in every second."""
    for arm, seed in (("cobot", 1), ("cobot", 2), ("cobot", 3), ("kr270", 1), ("kr270", 2), ("kr270", 3)):
        yield simulated_log(arm, seed)


def simulated_log(arm: str, seed: int) -> Log:
    """One recording of a built-in arm that follows a random motion."""
    model = read_model(arm)
    joints = model.robot.joints
    motion = random_fourier(model.robot.limits, SECONDS, seed=seed).at(np.arange(0.0, SECONDS, 1.0 / RATE))
    torque = model.torque(motion, model.nominal_values)
    usual = np.sqrt(np.mean(torque**2, axis=0))
    missing = {
        1: (),
        2: (JointSpring((joints[1],)), 0.2 * usual[1]),
        3: (StribeckFriction((joints[2],)), 0.15 * usual[2]),
    }[seed]
    plant = model
    if missing:
        effect, size = missing
        names = [parameter.name for parameter in effect.parameters(model.robot)]
        plant = model + effect
        plant = replace(plant, stated={**plant.stated, names[0]: Prior(float(size))})
    run = simulate(plant, plant.nominal_values, model.robot.drive_gain, motion, model, seed=seed)
    return shortened(f"{arm} {seed}", arm, model, run)
