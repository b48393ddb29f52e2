"""A log of a simulated arm, of which every unit, sign and order is known."""

from functools import cache
from typing import NamedTuple

import numpy as np

from exidyn.identify.arm.motion import Motion
from exidyn.identify.model import Model
from exidyn.identify.robot_files.robot_file import read_model


class SimulatedLog(NamedTuple):
    """20 s of the built-in cobot at 100 Hz: time (t,) [s], the rest (t, n) in SI, current with 2 % noise."""

    model: Model
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    torque: np.ndarray
    current: np.ndarray


@cache
def cobot_log() -> SimulatedLog:
    model, rng = read_model("cobot"), np.random.default_rng(3)
    time, rate = np.arange(2000) / 100.0, 2 * np.pi * np.arange(1, 5) / 10.0
    size = rng.normal(size=(2, 6, 4)) * 0.4 / np.arange(1, 5)
    sine, cosine = np.sin(time[:, None] * rate), np.cos(time[:, None] * rate)
    position = np.array([0.0, -1.5, 0.5, -1.0, 0.5, 0.0]) + sine @ size[0].T + cosine @ size[1].T
    velocity = cosine @ (size[0] * rate).T - sine @ (size[1] * rate).T
    acceleration = -sine @ (size[0] * rate**2).T - cosine @ (size[1] * rate**2).T
    motion = model.loaded(Motion.of(time, position, velocity, acceleration))
    torque = model.torque(motion, model.nominal_values)
    torque += 0.02 * torque.std(axis=0) * rng.normal(size=torque.shape)
    return SimulatedLog(model, time, position, velocity, torque, torque / model.robot.drive_gain)


def columns(pattern: str, values: np.ndarray) -> dict[str, np.ndarray]:
    """Values (t, n) as columns, named by a pattern with {k} from 1."""
    return {pattern.format(k=k + 1): column for k, column in enumerate(values.T)}
