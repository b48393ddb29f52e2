"""Mistakes that make a correct log wrong."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio as pin

from exidyn.identification.effects import RigidBody
from exidyn.identification.plausible.change import with_gravity

from ..injected import _motion, push_torque
from .recordings import Log

Make = Callable[[Log], Log]
Rows = dict[int, dict[int, float]]
"""Entries of a matrix that differ from the identity; joints are from 0, negative ones from the last."""


def columns(position: Rows, torque: Rows | None = None) -> Make:
    """Linear combinations of the columns; by default, the efforts are those that belong to the positions."""

    def make(log: Log) -> Log:
        matrices = []
        for rows in (position, torque or {}):
            matrices.append(np.eye(log.model.robot.dof))
            for row, entries in rows.items():
                matrices[-1][row] = 0.0
                for column, value in entries.items():
                    matrices[-1][row, column] = value
        of_torque = np.linalg.inv(matrices[0]).T if torque is None else matrices[1]
        return log._replace(position=log.position @ matrices[0].T, effort=log.effort @ of_torque.T)

    return make


def net_force(log: Log) -> Log:
    """Efforts that are M(q) times the acceleration."""
    motion, model = _motion(log.run), log.model
    bodies = replace(model, effects=tuple(e for e in model.effects if isinstance(e, RigidBody)))
    still = replace(motion, velocity=0.0 * motion.velocity)
    weight = bodies.torque(replace(still, acceleration=still.velocity), bodies.nominal_values)
    torque = bodies.torque(still, bodies.nominal_values) - weight
    torque += 0.01 * torque.std(axis=0) * np.random.default_rng(0).normal(size=torque.shape)
    return log._replace(effort=torque / per_unit(log))


def per_unit(log: Log) -> np.ndarray:
    """Torque per unit of the effort, shape (n,)."""
    return log.model.robot.drive_gain if log.measures == "current" else np.ones(log.model.robot.dof)


def two_clocks(log: Log) -> Log:
    """Efforts come later and later, by 0.6 % of the time."""
    late = [np.interp(0.994 * log.time, log.time, column) for column in log.effort.T]
    return log._replace(effort=np.stack(late, axis=1))


def wrong_axis(log: Log) -> Log:
    """The description turns the axis of joint 3 by 90 degrees."""
    kinematics, turn = (
        log.model.robot.kinematics.copy(),
        pin.SE3(pin.utils.rotate("x", np.pi / 2), np.zeros(3)),
    )
    kinematics.jointPlacements[3] = kinematics.jointPlacements[3] * turn
    kinematics.jointPlacements[4] = turn.inverse() * kinematics.jointPlacements[4]
    return log._replace(model=replace(log.model, robot=replace(log.model.robot, kinematics=kinematics)))


def frozen(log: Log) -> Log:
    """Positions stand still for a fifth of the time, efforts do not."""
    position, share = log.position.copy(), log.time / log.time[-1]
    position[(share > 0.4) & (share < 0.6)] = position[np.searchsorted(share, 0.4)]
    return log._replace(position=position)


def pushed(log: Log) -> Log:
    """Three pushes on the last link, each of half the usual torque of the joint that it loads most."""
    torque, share, rng = log.effort.copy(), log.time / log.time[-1], np.random.default_rng(1)
    for begin, end in ((0.15, 0.2), (0.55, 0.63), (0.8, 0.83)):
        rows = (share > begin) & (share < end)
        load = push_torque(log.model.robot.kinematics, log.position[rows], rng.normal(size=3)) / per_unit(log)
        size = np.max(np.sqrt(np.mean(load**2, axis=0) / np.mean(log.effort**2, axis=0)))
        torque[rows] += 0.5 * load / size
    return log._replace(effort=torque)


SAME: Rows = {}
ELBOW: Rows = {2: {1: 1.0, 2: 1.0}}
MISTAKES: dict[str, tuple[Make, tuple[str, ...]]] = {
    "positions of joints 1 and 2 times 1.2": (columns({0: {0: 1.2}, 1: {1: 1.2}}, SAME), ()),
    "joint 2 counts the other way": (columns({1: {1: -1.0}}), ()),
    "joint 3 counts the other way": (columns({2: {2: -1.0}}), ()),
    "position of joint 2 negated": (columns({1: {1: -1.0}}, SAME), ()),
    "position of joint 3 negated": (columns({2: {2: -1.0}}, SAME), ()),
    "effort of joint 3 times 3": (columns(SAME, {2: {2: 3.0}}), ("drive_gain",)),
    "efforts are M times acceleration": (net_force, ()),
    "differential wrist": (
        columns({-2: {-2: 1.0, -1: 1.0}, -1: {-2: 1.0, -1: -1.0}}), ("kinematic_coupling",)),
    "columns of joints 2 and 3 exchanged": (columns({1: {2: 1.0}, 2: {1: 1.0}}), ()),
    "columns of joints 4 and 5 exchanged": (columns({3: {4: 1.0}, 4: {3: 1.0}}), ()),
    "two clocks": (two_clocks, ("time_delay",)),
    "wrong axis of joint 3": (wrong_axis, ()),
    "gravity on its side": (
        lambda log: log._replace(model=with_gravity(log.model, np.array([9.81, 0.0, 0.0]))), ("base_tilt",)),
    "frozen positions": (frozen, ()),
    "three pushes": (pushed, ("contact_event",)),
    "elbow relative to the ground": (columns(ELBOW, SAME), ("kinematic_coupling",)),
    "elbow relative to the ground, torques of motors": (columns(ELBOW), ("kinematic_coupling",)),
}  # fmt: skip
"""Mistake -> function that makes it, and effects whose names describe it."""
