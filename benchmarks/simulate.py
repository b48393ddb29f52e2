"""Closed-loop simulation beside MuJoCo on the same arm.

The arm is the built-in KR270: six joints, friction, rotors, a spring balancer. Both simulators follow the
same commands under the same cascade, MuJoCo by the exported MJCF and with its loop closed in Python, as one
would write it; times are CPU seconds of one thread, the least of several.
"""

import os
import time
from typing import Any, NamedTuple

os.environ["OMP_NUM_THREADS"] = "1"  # before numpy: one thread on both sides

import mujoco
import numpy as np
from common import options, save, show

from exidyn.identification.arm.motion import Motion
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.export.mjcf import STEP
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.plant import DriveControl, Plant, steps
from exidyn.identification.simulation.plant.typical import typical_parts
from exidyn.identification.simulation.simulate import follow
from exidyn.trajectories.random_motion import random_fourier

FINE = 2.5e-4
"""Step of MuJoCo to agree with [s]: its loop is closed once a step, and so lags behind by half of one."""
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


def against_mujoco(seconds: float, repeats: int) -> dict[str, float]:
    """Real-time factors, and how far the two trajectories are apart."""
    model = read_model("kr270")
    text, control = FORMATS["mjcf"].text(Portable.of(model)), typical_parts(model)[0]
    motion, taken = motion_of(model, seconds), []
    for _ in range(repeats):  # by turns, since the machine may be slower at one time than at another
        we, they = ours(model, control, motion), theirs(text, control, motion)
        taken.append((we.seconds, they.seconds, bare(text, motion)))
    least, length = np.min(taken, axis=0), motion.time[-1]
    how = "without Numba" if steps.compiled(steps.through) is steps.through else "compiled"
    names = (f"exidyn, {how}", "MuJoCo, loop closed in Python", "MuJoCo, steps alone")
    rows = [[name, t, length / t, 1e6 * t / len(motion)] for name, t in zip(names, least, strict=True)]
    head = ["simulator", "CPU s", "times real time", "us a tick"]
    show(f"{length:.0f} s of KR270, steps of 1 ms", head, rows)
    return {
        "real_time_factor": length / least[0],
        "real_time_factor_over_mujoco": least[1] / least[0],
        "real_time_factor_over_mujoco_steps_alone": least[2] / least[0],
        **_apart(motion, we, theirs(text, control, motion, FINE)),
    }


def _apart(motion: Motion, we: Run, they: Run) -> dict[str, float]:
    """Table and figures of the difference to MuJoCo in fine steps."""
    tracking = _rms(we.position - motion.position)
    position = _rms(we.position - they.position)
    torque = _rms((we.torque - they.torque)[1:]) / _rms(we.torque[1:])
    rows = [
        [f"joint{k + 1}", *numbers] for k, numbers in enumerate(zip(tracking, position, torque, strict=True))
    ]
    head = ["", "rms tracking error rad", "rms apart rad", "torque apart, share of rms"]
    show(f"The two simulations, MuJoCo in steps of {1e3 * FINE:g} ms", head, rows)
    return {
        "position_apart_over_tracking_error": float(np.max(position / tracking)),
        "torque_apart": max(torque),
    }


def _rms(values: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(values**2, axis=0))


def main() -> None:
    chosen = options(__doc__.splitlines()[0])
    figures: dict[str, Any] = against_mujoco(*((8.0, 3) if chosen.quick else (12.0, 12)))
    save(chosen.json, figures)


if __name__ == "__main__":
    main()
