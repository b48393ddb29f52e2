"""One arm in two simulators, under the same commands and the same cascade."""

import time
from typing import NamedTuple

import mujoco
import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.export.mjcf import STEP
from exidyn.identification.model import Model
from exidyn.identification.simulation.plant import DriveControl, Plant
from exidyn.identification.simulation.simulate import follow
from exidyn.trajectories.random_motion import random_fourier

TICK = 0.002
"""From command to command, and from sample to sample [s]."""


def motion_of(model: Model, seconds: float, seed: int = 5) -> Motion:
    """A random motion at the usual rate, at rest to begin and to end with."""
    return random_fourier(model.robot.limits, seconds, seed=seed).at(np.arange(0.0, seconds, TICK))


class Run(NamedTuple):
    """What one simulator did: position [rad] and torque [N m] a tick, each (t, n), and CPU time [s]."""

    position: np.ndarray
    torque: np.ndarray
    seconds: float


def ours(model: Model, control: DriveControl, motion: Motion) -> Run:
    """The plant, with sensors that add nothing."""
    gain = model.robot.drive_gain
    plant = Plant(model, model.nominal_values, gain, motion.position[0], control)
    start = time.process_time()
    signals = follow(plant, motion.position, motion.velocity, TICK)
    taken = time.process_time() - start
    return Run(signals["position"].values, gain * signals["current"].values, taken)


def theirs(text: str, control: DriveControl, motion: Motion, step: float = STEP) -> Run:
    """MuJoCo on the exported arm under the same cascade, its loop closed every step [s]."""
    arm = mujoco.MjModel.from_xml_string(text)
    arm.opt.timestep = step
    data, (position, velocity) = mujoco.MjData(arm), _finer(motion, step)
    data.qpos[:] = motion.position[0]
    integral = _holding(arm, data) / (control.velocity_gain * control.integral_gain)
    seen, torques = [], []
    limit, ticks = arm.actuator_ctrlrange[:, 1], round(TICK / step)
    start = time.process_time()
    for row, wanted in enumerate(position):
        error = control.feed_forward * velocity[row] - data.qvel
        error += control.position_gain * (wanted - data.qpos)
        torque = control.velocity_gain * (error + control.integral_gain * integral)
        integral = integral + step * np.where(np.abs(torque) > limit, 0.0, error)
        if row % ticks == 0:
            seen.append(data.qpos.copy())
            torques.append(np.clip(torque, -limit, limit))
        data.ctrl[:] = torque
        mujoco.mj_step(arm, data)
    return Run(np.array(seen), np.array(torques), time.process_time() - start)


def bare(text: str, motion: Motion) -> float:
    """CPU time of MuJoCo's steps alone, nothing commanded, from where the motion begins [s]."""
    arm = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(arm)
    data.qpos[:] = motion.position[0]
    start = time.process_time()
    mujoco.mj_step(arm, data, nstep=len(motion) * round(TICK / STEP))
    return time.process_time() - start


def _finer(motion: Motion, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Commands at every step of MuJoCo, on lines between those of the ticks, (t, n)."""
    fine = np.arange(0.0, motion.time[-1] + 0.5 * step, step)
    columns = range(motion.position.shape[1])
    return tuple(
        np.stack([np.interp(fine, motion.time, values[:, k]) for k in columns], axis=1)
        for values in (motion.position, motion.velocity)
    )


def _holding(arm: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Torque of the motors that holds the arm where it is [N m]."""
    data.qacc[:] = 0.0
    mujoco.mj_inverse(arm, data)
    return data.qfrc_inverse - arm.actuator_biasprm[:, 0]
