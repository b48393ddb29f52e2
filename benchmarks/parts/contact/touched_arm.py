"""An arm of three joints in plain MuJoCo that follows a motion, free or touched with a known force.

The force acts at the flange by MuJoCo's own Jacobian; torque and position are recorded with noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import mujoco
import numpy as np

from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import read_model

MJCF = """<mujoco><option timestep="0.002" integrator="implicitfast"/><worldbody>
<body name="turret"><joint name="pan" axis="0 0 1" damping="1.5" armature="0.3"/>
<geom type="capsule" size=".05" fromto="0 0 0 0 0 .3" density="900"/>
<body name="upper" pos="0 0 .3"><joint name="lift" axis="0 1 0" damping="2" armature="0.4"/>
<geom type="capsule" size=".04" fromto="0 0 0 .4 .02 0" density="900"/>
<body name="fore" pos=".4 .02 0"><joint name="elbow" axis="0 1 0" damping="1" armature="0.2"/>
<geom type="capsule" size=".03" fromto="0 0 0 .3 0 .03" density="900"/>
<site name="flange" pos=".3 0 .03"/></body></body></body></worldbody></mujoco>"""
STEP = 0.002
TORQUE_NOISE, ENCODER = 0.05, 2e-6
"""Standard deviations of the noise of torque [N m] and position [rad]."""
STIFFNESS, DAMPING = 400.0, 40.0
"""Gains of the joint controllers [N m/rad], [N m s/rad]."""
WAVES = 4


@dataclass(frozen=True)
class Touch:
    """A constant force on the flange."""

    force: tuple[float, float, float]  # Force in the axes of the base [N]
    start: float  # Its start [s]
    end: float  # Its end [s]


def model() -> Model:
    """The arm as exidyn reads it from the MJCF."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "touched.xml"
        path.write_text(MJCF)
        return read_model(path)


def run(
    name: str, seed: int = 0, seconds: float = 25.0, touches: Sequence[Touch] = (), speed: float = 1.0
) -> Recording:
    """A run along random waves; `speed` 0 holds a pose."""
    arm = mujoco.MjModel.from_xml_string(MJCF)
    data, random = mujoco.MjData(arm), np.random.default_rng(seed)
    time = STEP * np.arange(int(seconds / STEP))
    wanted, wanted_speed = _waves(random, time, speed)
    position, torque = np.zeros((2, len(time), arm.nv))
    data.qpos[:], data.qvel[:] = wanted[0], wanted_speed[0]
    for k, now in enumerate(time):
        data.qfrc_applied[:] = 0.0
        mujoco.mj_forward(arm, data)
        servo = STIFFNESS * (wanted[k] - data.qpos) + DAMPING * (wanted_speed[k] - data.qvel)
        position[k], torque[k] = data.qpos, servo + data.qfrc_bias
        data.qfrc_applied[:] = torque[k]
        for touch in touches:
            if touch.start <= now < touch.end:
                data.qfrc_applied[:] += _jacobian(arm, data).T @ np.array(touch.force)
        mujoco.mj_step(arm, data)
    position = position + ENCODER * random.normal(size=position.shape)
    torque = torque + TORQUE_NOISE * random.normal(size=torque.shape)
    return Recording.from_arrays(model(), time, position, torque=torque, name=name)


def push_torque(position: np.ndarray, force: Sequence[float]) -> np.ndarray:
    """Torque of each joint by a force on the flange at positions (t, n), by MuJoCo, shape (t, n) [N m]."""
    arm = mujoco.MjModel.from_xml_string(MJCF)
    data, torque = mujoco.MjData(arm), np.zeros_like(position)
    for row, q in enumerate(position):
        data.qpos[:] = q
        mujoco.mj_forward(arm, data)
        torque[row] = _jacobian(arm, data).T @ np.array(force)
    return torque


def _jacobian(arm: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Jacobian of the flange's position, shape (3, n)."""
    jacobian = np.zeros((3, arm.nv))
    mujoco.mj_jacSite(arm, data, jacobian, None, 0)
    return jacobian


def _waves(random: np.random.Generator, time: np.ndarray, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Commanded positions and velocities, each (t, 3)."""
    size, phase = random.uniform(0.1, 0.35, (WAVES, 3)), random.uniform(0.0, 2 * np.pi, (WAVES, 3))
    position, velocity = np.zeros((2, len(time), 3))
    for k in range(WAVES):
        rate = speed * 2 * np.pi * 0.13 * (k + 1)
        position += size[k] * np.sin(rate * time[:, None] + phase[k])
        velocity += size[k] * rate * np.cos(rate * time[:, None] + phase[k])
    return position + np.array([0.0, 0.4, -0.8]), velocity
