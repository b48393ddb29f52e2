"""Errors on the third motion, by rollouts of plain MuJoCo: the benchmark's own, without exidyn in the loop.

Simulations start in the states of the real arm, without errors of sensors, and follow its commands for 2 s.
Delays are those that MuJoCo compiles; what was commanded before a start is in their buffers.
"""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from exidyn.identification.arm.newton_euler import flange_position
from exidyn.identification.arm.robot import Robot

from .real_arm import Motion, interpolated, places_of

HORIZON = 2.0
"""Time after a start at which the tool points are compared [s]."""
STARTS = 24
"""Number of starts, evenly spaced."""
FAR = 10.0
"""Distance that counts for a simulation that has diverged [m]."""


def tool_error(text: str, robot: Robot, motion: Motion) -> float:
    """RMS distance between the tool points of a file's simulation and of the real arm [mm]."""
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    last = np.searchsorted(motion.time, motion.time[-1] - HORIZON - 1e-9, side="right") - 1
    rows = np.unique(np.linspace(0, last, STARTS).astype(int))
    ahead = int(round(HORIZON / (motion.time[1] - motion.time[0])))
    ends = [rolled(model, robot.joints, motion, int(row)) for row in rows]
    distances = [
        _distance(robot, end, real) for end, real in zip(ends, motion.position[rows + ahead], strict=True)
    ]
    return 1e3 * float(np.sqrt(np.mean(np.square(distances))))


def rolled(model: mujoco.MjModel, joints: Sequence[str], motion: Motion, row: int) -> np.ndarray:
    """Positions `HORIZON` after sample `row`, shape (n,) [rad]; not finite if the simulation has diverged."""
    places, data, start = places_of(model, joints), mujoco.MjData(model), motion.time[row]
    qpos, dofs, servos = ([getattr(place, name) for place in places] for name in ("qpos", "dof", "actuator"))
    data.qpos[qpos], data.qvel[dofs] = motion.position[row], motion.velocity[row]
    _remember(model, data, servos, motion, start)
    steps = start + model.opt.timestep * np.arange(round(HORIZON / model.opt.timestep))
    for control in interpolated(steps, motion.time, motion.command):
        data.ctrl[servos] = control
        mujoco.mj_step(model, data)
    return np.asarray(data.qpos[qpos])


def _remember(
    model: mujoco.MjModel, data: mujoco.MjData, servos: Sequence[int], motion: Motion, start: float
) -> None:
    """Write what was commanded before a start into the buffers of actuators with a delay."""
    for joint, servo in enumerate(servos):
        if count := int(model.actuator_history[servo, 0]):
            past = model.opt.timestep * np.arange(-count, 0)
            values = interpolated(start + past, motion.time, motion.command[:, joint : joint + 1])
            mujoco.mj_initCtrlHistory(model, data, servo, past, values)


def _distance(robot: Robot, simulated: np.ndarray, real: np.ndarray) -> float:
    """Distance between the tool points at two positions (n,) [m], at most `FAR`."""
    if not np.all(np.abs(simulated) < 1e3):
        return FAR
    data: Any = robot.kinematics.createData()
    ends = [flange_position(robot.kinematics, robot.flange, position, data) for position in (simulated, real)]
    return min(float(np.linalg.norm(ends[0] - ends[1])), FAR)
