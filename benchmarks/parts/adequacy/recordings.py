"""Correct recordings: real arms cut to at most 24 s, and simulated arms with or without an effect."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from exidyn.identification.effects import JointSpring, Prior, StribeckFriction
from exidyn.identification.model import Model
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import simulate
from exidyn.trajectories.random_motion import random_fourier

from ..injected import effort
from ..real.data import FOLDER, KR300, UR10E

SECONDS, RATE = 24.0, 130.0
"""Longest duration [s], and largest sampling rate: faster recordings are averaged over samples [Hz]."""


class Log(NamedTuple):
    """A description of an arm, and a recording."""

    model: Model
    time: np.ndarray  # (t,) [s]
    position: np.ndarray  # (t, n) [rad, m]
    effort: np.ndarray  # (t, n), currents or torques
    measures: str  # "current" or "torque"

    @property
    def run(self) -> Recording:
        """The recording."""
        values = {"position": self.position, self.measures: self.effort}
        signals = {name: Signal(self.time, array) for name, array in values.items()}
        return Recording("run", self.model, signals)


def shortened(model: Model, run: Recording) -> Log:
    """The first `SECONDS` at `RATE` at most; positions and efforts alone, at the same times."""
    position, measures = run.signals["position"], effort(run)
    time = position.time - position.time[0]
    step = max(round(1.0 / np.median(np.diff(time)) / RATE), 1)
    count = int(np.searchsorted(time, SECONDS)) // step

    def mean(array: np.ndarray) -> np.ndarray:
        return array[: count * step].reshape(count, step, *array.shape[1:]).mean(axis=1)

    torque = run.signals[measures].at(position.time)
    return Log(model, mean(time), mean(position.values), mean(torque), measures)


def recorded(robot: str, name: str) -> Log:
    """A recording of the data folder, by the path of its description there."""
    model = read_model(FOLDER / robot)
    return shortened(model, import_source((FOLDER / robot).parent / f"{name}.csv.gz", model)[0])


def simulated(arm: str, seed: int) -> Log:
    """A built-in arm on a random motion: seed 1 as described, 2 with a spring, 3 with Stribeck friction."""
    model = read_model(arm)
    motion = random_fourier(model.robot.limits, SECONDS, seed=seed).at(np.arange(0.0, SECONDS, 1.0 / RATE))
    usual = np.sqrt(np.mean(model.torque(motion, model.nominal_values) ** 2, axis=0))
    plant, joints = model, model.robot.joints
    if seed > 1:
        effect = JointSpring((joints[1],)) if seed == 2 else StribeckFriction((joints[2],))
        size = 0.2 * usual[1] if seed == 2 else 0.15 * usual[2]
        plant = model + effect
        stated = {effect.parameters(model.robot)[0].name: Prior(float(size))}
        plant = replace(plant, stated={**plant.stated, **stated})
    run = simulate(plant, plant.nominal_values, model.robot.drive_gain, motion, model, seed=seed)
    return shortened(model, run)


RUNS = {
    "airbot_play/robot.toml": ("opt", "N7T25_5", "ga_N12T25"),
    "baxter_left/left.urdf": ("train_random", "train_sin_xyz_8s_t2_tz_4t_r10", "test_square"),
    "dvrk_psm/robot.toml": ("fourier_test", "fourier_test2", "fourier_test5"),
    "emps/robot.toml": ("train",),
    "kuka_lwr4/arm.urdf": ("meas_1", "meas_2", "meas_3"),
    "panda_gaz/panda.urdf": ("traj1",),
    "pendubot/robot.toml": ("h1",),
    "staubli_tx40/robot.toml": ("train",),
}
CORRECT: dict[str, Callable[[], Log]] = {
    **{f"{a} {k}": partial(simulated, a, k) for a in ("cobot", "kr270") for k in (1, 2, 3)},
    **{
        f"{data.key} {name}": lambda data=data, name=name: shortened(data.model(), data.run(name))
        for data, names in ((KR300, (*KR300.train, *KR300.held_out[1:3])), (UR10E, UR10E.train[:4]))
        for name in names
    },
    **{f"{r.split('/')[0]} {n}": partial(recorded, r, n) for r, names in RUNS.items() for n in names},
}
"""Correct recordings by name; the first word is the arm."""
