"""Mistakes that make a correct log wrong, each with the effects that would name it truly."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.motion import Motion
from exidyn.identification.effects import RigidBody
from exidyn.identification.plausible.mistake import with_gravity

from ..injected import SMOOTH, _slow
from .recordings import Log


class Mistake(NamedTuple):
    """One kind of mistake."""

    name: str
    make: Callable[[Log], Log]
    true: tuple[str, ...] = ()  # effects whose name describes the mistake


def columns(log: Log, position: np.ndarray, torque: np.ndarray) -> Log:
    """The log with linear combinations of its columns, matrices (n, n)."""
    return log.having(log.position @ position.T, log.effort @ torque.T)


def diagonal(log: Log, joint: int, factor: float) -> np.ndarray:
    matrix = np.eye(log.model.robot.dof)
    matrix[joint, joint] = factor
    return matrix


def positions_scaled(log: Log) -> Log:
    n = log.model.robot.dof
    scale = np.ones(n)
    scale[:2] = 1.2
    return columns(log, np.diag(scale), np.eye(n))


def counts_backwards(joint: int) -> Callable[[Log], Log]:
    return lambda log: columns(log, diagonal(log, joint, -1.0), diagonal(log, joint, -1.0))


def position_negated(joint: int) -> Callable[[Log], Log]:
    return lambda log: columns(log, diagonal(log, joint, -1.0), np.eye(log.model.robot.dof))


def effort_scaled(log: Log) -> Log:
    return columns(log, np.eye(log.model.robot.dof), diagonal(log, 2, 3.0))


def net_force(log: Log) -> Log:
    """Efforts that are M(q) times the acceleration."""
    motion = _motion(log)
    robot = log.model.robot
    accelerating = replace(motion, velocity=np.zeros_like(motion.velocity))
    still = replace(accelerating, acceleration=np.zeros_like(motion.velocity))
    bodies = replace(log.model, effects=tuple(e for e in log.model.effects if isinstance(e, RigidBody)))
    torque = bodies.torque(accelerating, bodies.nominal_values) - bodies.torque(still, bodies.nominal_values)
    noise = np.random.default_rng(0).normal(size=torque.shape) * 0.01 * torque.std(axis=0)
    gain = robot.drive_gain if "current" in log.run.signals else np.ones(robot.dof)
    return log.having(torque=(torque + noise) / gain)


def differential(log: Log) -> Log:
    """The last two positions are those of the motors of a differential, their sum and difference."""
    matrix = np.eye(log.model.robot.dof)
    matrix[-2:, -2:] = [[1.0, 1.0], [1.0, -1.0]]
    return columns(log, matrix, np.linalg.inv(matrix).T)


def exchanged(first: int, second: int) -> Callable[[Log], Log]:
    def make(log: Log) -> Log:
        order = np.eye(log.model.robot.dof)
        order[[first, second]] = order[[second, first]]
        return columns(log, order, order)

    return make


def two_clocks(log: Log) -> Log:
    """Efforts come later and later, by 0.6 % of the time."""
    late = [np.interp(log.time * 0.994, log.time, column) for column in log.effort.T]
    return log.having(torque=np.stack(late, axis=1))


def wrong_axis(log: Log) -> Log:
    """The axis of joint 3 is turned by 90 degrees in the description."""
    kinematics = log.model.robot.kinematics.copy()
    turn = pin.SE3(pin.utils.rotate("x", np.pi / 2), np.zeros(3))
    kinematics.jointPlacements[3] = kinematics.jointPlacements[3] * turn
    for joint in range(4, kinematics.njoints):
        if kinematics.parents[joint] == 3:
            kinematics.jointPlacements[joint] = turn.inverse() * kinematics.jointPlacements[joint]
    return log.having(model=replace(log.model, robot=replace(log.model.robot, kinematics=kinematics)))


def on_its_side(log: Log) -> Log:
    return log.having(model=with_gravity(log.model, np.array([9.81, 0.0, 0.0])))


def frozen(log: Log) -> Log:
    """Positions stand still for 4 s, efforts do not."""
    position, inside = log.position.copy(), (log.time > 0.4 * log.time[-1]) & (log.time < 0.6 * log.time[-1])
    position[inside] = position[inside][0]
    return log.having(position)


def pushed(log: Log) -> Log:
    """Three pushes of 0.6 to 2 s with a tenth of the arm's weight."""
    robot, torque = log.model.robot, log.effort.copy()
    data, rng = robot.kinematics.createData(), np.random.default_rng(1)
    usual = np.sqrt(np.mean(log.effort**2, axis=0))
    gain = robot.drive_gain if "current" in log.run.signals else np.ones(robot.dof)
    for begin, end in ((0.15, 0.2), (0.55, 0.63), (0.8, 0.83)):
        rows = np.flatnonzero((log.time > begin * log.time[-1]) & (log.time < end * log.time[-1]))
        force, load = rng.normal(size=3), np.zeros((len(rows), robot.dof))
        for place, row in enumerate(rows):
            jacobian = pin.computeJointJacobian(robot.kinematics, data, log.position[row], robot.dof)
            load[place] = (data.oMi[robot.dof].rotation @ jacobian[:3]).T @ force / gain
        size = np.max(np.sqrt(np.mean(load**2, axis=0)) / usual)
        torque[rows] -= 0.5 * load / size
    return log.having(torque=torque)


def elbow(motors: bool) -> Callable[[Log], Log]:
    """Joint 3 is given relative to the ground; torques are those of the joints or of the motors."""

    def make(log: Log) -> Log:
        matrix = np.eye(log.model.robot.dof)
        matrix[2, 1] = 1.0
        return columns(log, matrix, np.linalg.inv(matrix).T if motors else np.eye(len(matrix)))

    return make


def _motion(log: Log) -> Motion:
    position = _slow(log.position, log.time) if len(log.time) > 100 else log.position
    velocity = np.gradient(position, log.time, axis=0)
    return Motion.of(log.time, position, velocity, np.gradient(velocity, log.time, axis=0))


MISTAKES = (
    Mistake("positions of joints 1 and 2 times 1.2", positions_scaled),
    Mistake("joint 2 counts the other way", counts_backwards(1)),
    Mistake("joint 3 counts the other way", counts_backwards(2)),
    Mistake("position of joint 2 negated", position_negated(1)),
    Mistake("position of joint 3 negated", position_negated(2)),
    Mistake("effort of joint 3 times 3", effort_scaled, ("drive_gain",)),
    Mistake("efforts are M times acceleration", net_force),
    Mistake("differential wrist", differential, ("kinematic_coupling",)),
    Mistake("columns of joints 2 and 3 exchanged", exchanged(1, 2)),
    Mistake("columns of joints 4 and 5 exchanged", exchanged(3, 4)),
    Mistake("two clocks", two_clocks, ("time_delay",)),
    Mistake("wrong axis of joint 3", wrong_axis),
    Mistake("gravity on its side", on_its_side, ("base_tilt",)),
    Mistake("frozen positions", frozen),
    Mistake("three pushes", pushed, ("contact_event",)),
    Mistake("elbow relative to the ground", elbow(False), ("kinematic_coupling",)),
    Mistake("elbow relative to the ground, motor torques", elbow(True), ("kinematic_coupling",)),
)
