"""Effort: what a jog's drive had to do, parted into what gravity and what friction ask for.

At a constant crawl a drive carries the torque at rest and pushes against friction. At the same places there
and back the first is the same and the second changes sign: they are the mean and half the difference.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.newton_euler import flange_position
from exidyn.identification.arm.robot import Robot
from exidyn.identification.model import Model

from .there_and_back import Course, Way

STEADY = 0.95
"""Share of the crawl above which the speed counts as constant [-]."""
PACE = 0.2
"""Share by which the mean speed when sampled may be another than the commanded, besides half of what it is
measured in steps of [-]: a joint that goes to each command in a step of its own and waits for the next is
sampled while it brakes or stands."""
BLOCKS = 12
"""Means that each way is parted into: noise of neighbouring samples is alike, that of such means is not."""


@dataclass(frozen=True)
class Effort:
    """What a joint's drive had to do at the middle of the way.

    Attributes:
        gravity: Torque in which there and back agree [N m].
        gravity_std: Standard deviation of that, by noise alone [N m].
        friction: By how much more it is with the motion [N m].
        friction_std: Standard deviation of that [N m].
        middle: Where, shape (n,) [rad] or [m].
        unit: "N m", or "N" for a joint that slides.
        source: What it was made from, for messages.
    """

    gravity: float
    gravity_std: float
    friction: float
    friction_std: float
    middle: np.ndarray
    unit: str
    source: str


def effort_of(course: Course, way: Way, model: Model) -> Effort | str:
    """Result of a jog for its joint's effort, or why there is none."""
    robot, joint = model.robot, way.joint
    if np.isfinite(course.current[:, joint]).any():
        if np.all(robot.drive_gain == 1.0):
            return "the robot file has no drive gains ([drive] gain), so that currents are no torque"
        torque, source = robot.drive_gain[joint] * course.current[:, joint], "drive gain or current"
    elif np.isfinite(course.torque[:, joint]).any():
        # What is known of joints, as the motors feel it through a coupled wrist.
        torque, source = (course.torque @ robot.to_motors.T)[:, joint], "the measured torque"
    else:
        return "the controller measures neither current nor torque"
    speed = course.speed[:, joint] * np.sign(way.distance)
    there, back = (sign * speed >= STEADY * way.speed for sign in (1.0, -1.0))
    known = np.isfinite(torque) & np.isfinite(course.position[:, joint])
    if min((there & known).sum(), (back & known).sum()) < 2 * BLOCKS:
        return "it was stopped before it had come back at a constant speed, or is too fast for such a way"
    paces = [_pace(course, way, rows) for rows in (there & known, back & known)]
    if max(abs(pace - 1.0) for pace in paces) > PACE + 0.5 * _speed_step(course, way):
        return (
            f"when it was sampled the joint was at {paces[0]:.2f} of the commanded speed there and "
            f"{paces[1]:.2f} back: it goes to each command in a step, and its current is not that of steady "
            "motion. Try a shorter cycle"
        )
    middle = np.nanmean(course.position[(there | back) & known], axis=0)
    unit = "N m" if robot.revolute[joint] else "N"
    places = course.position[:, joint] - middle[joint]
    direction = np.sign(way.distance)
    rows = [
        [1.0, place, sign * direction, value]
        for rows_of, sign in ((there & known, 1.0), (back & known, -1.0))
        for place, value in zip(_blocks(places[rows_of]), _blocks(torque[rows_of]), strict=True)
    ]
    values, deviations = _least_squares(np.array(rows))
    # Friction is with the motion where it has the sign of the velocity: +1 there if the way is positive.
    return Effort(values[0], deviations[0], values[2], deviations[2], middle, unit, source)


def _pace(course: Course, way: Way, rows: np.ndarray) -> float:
    """Mean of the measured speed as a share of the commanded; as commanded where it is not measured."""
    measured = course.velocity[rows, way.joint] / course.speed[rows, way.joint]
    return float(np.nanmean(measured)) if np.isfinite(measured).any() else 1.0


def _speed_step(course: Course, way: Way) -> float:
    """Smallest difference between two measured speeds, as a share of the crawl [-]."""
    values = course.velocity[:, way.joint]
    steps = np.diff(np.unique(values[np.isfinite(values)]))
    return float(steps.min()) / way.speed if len(steps) else 0.0


def _blocks(values: np.ndarray) -> np.ndarray:
    return np.array([part.mean() for part in np.array_split(values, BLOCKS)])


def _least_squares(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Torque = level + slope * place + friction * direction: the three, and their standard deviations."""
    matrix, torque = rows[:, :3], rows[:, 3]
    scale = np.maximum(np.abs(matrix).max(axis=0), 1e-12)
    values = np.linalg.lstsq(matrix / scale, torque, rcond=None)[0] / scale
    left = torque - matrix @ values
    variance = left @ left / (len(torque) - 3)
    covariance = variance * np.linalg.pinv((matrix / scale).T @ (matrix / scale))
    return values, np.sqrt(np.diag(covariance)) / scale


def torque_at_rest(model: Model, positions: np.ndarray, payload: str = "") -> np.ndarray:
    """Gravity, springs and balancers as the drives feel them, (t, n) [N m], or [N] where a joint slides.

    Args:
        model: Nominal.
        positions: Shape (t, n) [rad] or [m].
        payload: Name of the body on the flange; empty for none.
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
        axis: Axis about which the joint turns, or along which it slides, shape (3,) [-].
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
