"""One arm in two simulators, under the same commands and the same cascade."""

import time
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin
from common import show

from exidyn.identification.arm.motion import Motion
from exidyn.identification.effects import SpringBalancer
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.export.mjcf import STEP
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.identified import identified
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import parse_model, read_model
from exidyn.identification.simulation.plant import DriveControl, Plant
from exidyn.identification.simulation.simulate import follow, simulate
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


SLIDING = 10.0
"""Velocities over that of the reversal, above which dry friction has turned wholly."""


def a_fit(seconds: float) -> Fit:
    """What is identified of a simulated recording with noise."""
    model = read_model("kr270")
    motion = motion_of(model, seconds, seed=1)
    recording = simulate(model, model.nominal_values, model.robot.drive_gain, motion, model)
    return identify([recording])


def round_trips(seconds: float) -> dict[str, float]:
    """Torque of the fit, its identified model, and each export, on a motion that the fit has not seen."""
    fit = a_fit(seconds)
    motion = motion_of(fit.model, 20.0)[::5]
    model, portable = identified(fit), Portable.of(identified(fit))
    base = fit.model.regressor(motion)[:, :, fit.base.kept] @ fit.estimate.values
    whole = model.torque(motion, model.nominal_values)
    ways: dict[str, tuple[np.ndarray, np.ndarray]] = {
        "fit, identified": (base, whole),
        "identified, toml": (whole, _of_toml(portable, motion)),
        "identified, mjcf in MuJoCo": (whole, _of_mjcf(portable, motion)),
        "same part of it, urdf in Pinocchio": (_urdf_part(portable, motion), _of_urdf(portable, motion)),
    }
    slide = np.abs(motion.velocity) > SLIDING * np.max(portable.joints.reversal)
    rows = [
        [name, float(_relative(one, other, slide).max()), float(_relative(one, other, slide | True).max())]
        for name, (one, other) in ways.items()
    ]
    show("Torque on a motion held out, worst joint", ["from, to", "sliding", "with reversals"], rows)
    return {
        "consistency_error": rows[0][1],
        "torque_round_trip_error": max(row[1] for row in rows[1:]),
        "torque_round_trip_error_with_reversals": max(row[2] for row in rows[1:]),
    }


def _of_toml(portable: Portable, motion: Motion) -> np.ndarray:
    back = parse_model(FORMATS["toml"].text(portable))
    return back.torque(motion, back.nominal_values)


def _of_mjcf(portable: Portable, motion: Motion) -> np.ndarray:
    arm = mujoco.MjModel.from_xml_string(FORMATS["mjcf"].text(portable))
    data, torque = mujoco.MjData(arm), np.empty_like(motion.position)
    for row in range(len(motion)):
        data.qpos[:], data.qvel[:] = motion.position[row], motion.velocity[row]
        data.qacc[:] = motion.acceleration[row]
        mujoco.mj_inverse(arm, data)
        torque[row] = data.qfrc_inverse - arm.actuator_biasprm[:, 0]
    return torque


def _of_urdf(portable: Portable, motion: Motion) -> np.ndarray:
    arm = pin.buildModelFromXML(FORMATS["urdf"].text(portable))
    data = arm.createData()
    rows = zip(motion.position, motion.velocity, motion.acceleration, strict=True)
    bodies = np.array([pin.rnea(arm, data, *row) for row in rows])
    return bodies + arm.damping * motion.velocity + arm.upperDryFrictionLimit * np.sign(motion.velocity)


def _urdf_part(portable: Portable, motion: Motion) -> np.ndarray:
    """Torque of the model without what URDF cannot represent."""
    model, joints = portable.model, portable.joints
    whole = model.torque(motion, model.nominal_values)
    whole = whole - joints.armature * motion.acceleration - joints.constant
    for spring in portable.balancers:
        effect = SpringBalancer(spring.joint, d21=spring.d21, d22=spring.d22, phi=spring.phi)
        whole -= effect.regressor(model.robot, motion) @ [spring.stiffness, spring.preload]
    return whole


def _relative(one: np.ndarray, other: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rms of a difference over the rms, among some samples, shape (n,)."""
    return np.sqrt(np.sum((one - other) ** 2 * rows, axis=0) / np.sum(one**2 * rows, axis=0))
