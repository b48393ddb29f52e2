"""MuJoCo as the real arm: a model of Menagerie in which physics is concealed that its file does not have.

Its own servos follow commands; what is logged is what a controller logs, behind an encoder and a torque
sensor with noise.
"""

import warnings
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import Effect, Prior
from exidyn.identification.errors import RobotWarning
from exidyn.identification.in_mujoco.attached import Attached
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.robot_files.description import movable_joints
from exidyn.identification.robot_files.mjcf_drives import servos
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.random_motion import random_fourier

TICK = 0.004
"""From sample to sample [s]."""
STEP = 0.001
"""Of the simulation that is the real arm [s]."""
ENCODER = 2.0 * np.pi / 2.0**17
"""Resolution of positions [rad]."""
TORQUE_NOISE = 0.01
"""Standard deviation of the logged torque over its rms [-]."""
SPEED, ACCELERATION = 1.5, 6.0
"""Of the motion, at most [rad/s, rad/s^2]; MJCF states no limits of either."""
REACH = 1.2
"""Of a joint's motion about the middle of its range [rad]."""


class Case(NamedTuple):
    """A real arm, and what its file does not have."""

    name: str  # Of the case
    path: Path  # Of the file
    nominal: Model  # What the file describes
    real: Model | None  # The same with what is concealed; None where the file is the real arm
    concealed: tuple[tuple[str, int], ...]  # Effects and joints, from 0, to be named


def read_hinges(path: Path) -> tuple[mujoco.MjModel, Model]:
    """A file as MuJoCo compiles it, and its hinges as described; joints that slide, as fingers, are held."""
    compiled = mujoco.MjModel.from_xml_path(str(path))
    free, _ = movable_joints(path)
    joints = [name for name in free if compiled.joint(name).type[0] == mujoco.mjtJoint.mjJNT_HINGE]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RobotWarning)  # of gravcomp
        return compiled, read_model(path, joints)


def described(path: Path) -> Model:
    """What a file describes of its hinges, within limits that a motion can have."""
    _, model = read_hinges(path)
    limits, n = model.robot.limits, model.robot.dof
    lower = np.maximum(limits.position_lower, -2.0 * REACH)
    upper = np.minimum(limits.position_upper, 2.0 * REACH)
    middle, half = 0.5 * (lower + upper), np.minimum(0.45 * (upper - lower), REACH)
    free_limits = Limits(
        middle - half,
        middle + half,
        np.full(n, SPEED),
        np.full(n, ACCELERATION),
        np.full(n, 100.0),
        limits.torque,
    )
    return replace(model, robot=replace(model.robot, limits=free_limits))


def with_effects(model: Model, *effects: tuple[Effect, float]) -> Model:
    """The arm with further effects, every parameter of one value."""
    for effect, value in effects:
        names = [parameter.name for parameter in effect.parameters(model.robot)]
        model = replace(model + effect, stated=dict(model.stated) | {name: Prior(value) for name in names})
    return model


def record(case: Case, seconds: float, seed: int, name: str) -> Recording:
    """A log of the real arm on a random motion."""
    arm = mujoco.MjModel.from_xml_path(str(case.path))
    data = mujoco.MjData(arm)
    with Attached(arm, data, case.real) if case.real else nullcontext():
        return recorded(arm, data, case.nominal, seconds, seed, name)


def recorded(
    arm: mujoco.MjModel, data: mujoco.MjData, nominal: Model, seconds: float, seed: int, name: str
) -> Recording:
    """A log of an arm as it is in MuJoCo, on a random motion, by the joints of its nominal model."""
    arm.opt.timestep, arm.opt.integrator = STEP, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    joints = nominal.robot.joints
    places = [int(arm.joint(joint).qposadr[0]) for joint in joints]
    dofs = [int(arm.joint(joint).dofadr[0]) for joint in joints]
    motors = servos(arm, joints)
    motion = random_fourier(nominal.robot.limits, seconds, seed=seed).at(np.arange(0.0, seconds, TICK))
    position, effort = np.empty_like(motion.position), np.empty_like(motion.position)
    data.qpos[places] = motion.position[0]
    data.ctrl[motors] = motion.position[0]
    mujoco.mj_step(arm, data, round(1.0 / STEP))
    for row, command in enumerate(motion.position):
        position[row] = data.qpos[places]
        effort[row] = _tick(arm, data, motors, dofs, command, motion.velocity[row])
    random = np.random.default_rng(seed)
    # A sample's torque is the mean of the cycle behind it; that of two is at the position.
    effort[1:] = 0.5 * (effort[1:] + effort[:-1])
    effort += TORQUE_NOISE * np.sqrt(np.mean(effort**2, axis=0)) * random.normal(size=effort.shape)
    position = np.round(position / ENCODER) * ENCODER
    signals = {"position": position, "torque": effort, "command": motion.position}
    return Recording(name, nominal, {key: Signal(motion.time, values) for key, values in signals.items()})


def _tick(arm, data, motors, dofs, command, velocity) -> np.ndarray:  # noqa: ANN001
    """Go on to the next sample, commands moving between samples as controllers' do; mean torque (n,)."""
    count, total = round(TICK / STEP), np.zeros(len(dofs))
    for step in range(count):
        data.ctrl[motors], before = command + step * STEP * velocity, data.qvel[dofs]
        mujoco.mj_step(arm, data)
        # The integrator takes a servo's damping at the end of the step, which is what acts.
        total += data.qfrc_actuator[dofs] + arm.actuator_biasprm[motors, 2] * (data.qvel[dofs] - before)
    return total / count
