"""Nominal model of an arm that moves slowly: torque at rest, and where its flange goes."""

from dataclasses import dataclass
from functools import partial

import numpy as np
import pinocchio as pin

from exidyn.identify.arm.motion import Motion
from exidyn.identify.arm.newton_euler import flange_position
from exidyn.identify.arm.robot import Robot
from exidyn.identify.model import Model

from .there_and_back import Way


def torque_at_rest(model: Model, positions: np.ndarray, payload: str = "") -> np.ndarray:
    """Gravity, springs and balancers, as the drives feel them.

    Args:
        model: Nominal.
        positions: Shape (t, n) [rad] or [m].
        payload: Name of the body on the flange; empty for none.

    Returns:
        Shape (t, n) [N m], or [N] where a joint slides.
    """
    still = np.zeros_like(positions)
    motion = Motion.of(np.arange(len(positions), dtype=float), positions, still, still, payload=payload)
    torque = model.torque(model.loaded(motion), model.nominal_values)
    at_drives: np.ndarray = torque @ model.robot.to_motors.T
    return at_drives


@dataclass(frozen=True)
class FlangeWay:
    """Where the flange should go, in the base frame.

    Attributes:
        moved: Displacement, shape (3,) [m].
        axis: About which the joint turns, or along which it slides, in its positive sense, shape (3,) [-].
    """

    moved: np.ndarray
    axis: np.ndarray


def flange_way(robot: Robot, position: np.ndarray, way: Way) -> FlangeWay:
    """Where the flange goes by the robot's geometry, from a position (n,)."""
    far = position.copy()
    far[way.joint] += way.distance
    flange = partial(flange_position, robot.kinematics, robot.flange)
    moved = flange(far) - flange(position)
    data = robot.kinematics.createData()
    jacobian = pin.computeJointJacobians(robot.kinematics, data, position)[:, way.joint]
    return FlangeWay(moved, jacobian[3:] if robot.revolute[way.joint] else jacobian[:3])
