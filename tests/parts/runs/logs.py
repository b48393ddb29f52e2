"""A log of a simulated arm, of which every unit, sign and order is known."""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import described_model, read_model, urdf_text
from exidyn.identification.robot_files.urdf import parse_urdf


class SimulatedLog(NamedTuple):
    """20 s of an arm at 100 Hz: time (t,) [s], the rest (t, n) in SI, current with 2 % noise."""

    model: Model
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    torque: np.ndarray
    current: np.ndarray


@cache
def cobot_log() -> SimulatedLog:
    return _log(read_model("cobot"), np.array([0.0, -1.5, 0.5, -1.0, 0.5, 0.0]), 0.4)


def short_arm(name: str) -> Model:
    """The first four joints of a built-in arm, which carry the others; hypotheses about four are few."""
    arm = read_model(name)
    model = described_model("short", parse_urdf(urdf_text(arm), moving=arm.robot.joints[:4]))
    robot = replace(model.robot, inertias_stated=True, drive_gain=arm.robot.drive_gain[:4])
    stated = {key: prior for key, prior in arm.stated.items() if key in model.names}
    return replace(model, robot=robot, stated=stated)


@cache
def short_log() -> SimulatedLog:
    return _log(short_arm("cobot"), np.array([0.0, -1.5, 0.5, -1.0]), 0.4)


@cache
def kr270_log() -> SimulatedLog:
    """With its spring balancer, which holds the most of what joint 2 carries."""
    return _log(read_model("kr270"), np.array([0.0, -1.2, 1.1, 0.0, 0.3, 0.0]), 0.3)


def _log(model: Model, centre: np.ndarray, size: float) -> SimulatedLog:
    rng = np.random.default_rng(3)
    time, rate = np.arange(2000) / 100.0, 2 * np.pi * np.arange(1, 5) / 10.0
    sizes = rng.normal(size=(2, len(centre), 4)) * size / np.arange(1, 5)
    sine, cosine = np.sin(time[:, None] * rate), np.cos(time[:, None] * rate)
    position = centre + sine @ sizes[0].T + cosine @ sizes[1].T
    velocity = cosine @ (sizes[0] * rate).T - sine @ (sizes[1] * rate).T
    acceleration = -sine @ (sizes[0] * rate**2).T - cosine @ (sizes[1] * rate**2).T
    motion = model.loaded(Motion.of(time, position, velocity, acceleration))
    torque = model.torque(motion, model.nominal_values)
    torque += 0.02 * torque.std(axis=0) * rng.normal(size=torque.shape)
    return SimulatedLog(model, time, position, velocity, torque, torque / model.robot.drive_gain)


def columns(pattern: str, values: np.ndarray) -> dict[str, np.ndarray]:
    """Values (t, n) as columns, named by a pattern with {k} from 1."""
    return {pattern.format(k=k + 1): column for k, column in enumerate(values.T)}
