"""Effort: the torque of a jogged joint's drive, split into gravity and friction.

At a constant slow speed a drive carries the torque at rest and pushes against friction. At equal positions
there and back, the torque at rest is equal and friction changes its sign: they are the mean and half the
difference.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.newton_euler import flange_position
from exidyn.identification.arm.robot import Robot
from exidyn.identification.model import Model

from .there_and_back import Course, Travel

STEADY = 0.95
"""Share of the jog speed above which the speed counts as constant [-]."""
PACE = 0.2
"""Largest relative difference between mean sampled and commanded speed, beyond half the resolution of the
measured speed [-]: a joint that moves to each command in one step and waits for the next is sampled while it
decelerates or stands."""
BLOCKS = 12
"""Number of means per direction: noise of neighboring samples is correlated, noise of such means is not."""


@dataclass(frozen=True)
class Effort:
    """Torque of a joint's drive in the middle of the travel."""

    gravity: float  # mean torque of both directions [N m]
    gravity_std: float  # standard deviation of the mean due to noise [N m]
    # Half the torque difference between the directions, positive if it opposes the motion [N m].
    friction: float
    friction_std: float  # standard deviation of the friction due to noise [N m]
    middle: np.ndarray  # position in the middle, shape (n,) [rad] or [m]
    unit: str  # "N m", or "N" for a prismatic joint
    source: str  # signal from which the torque was computed, for messages


def effort_of(course: Course, travel: Travel, model: Model) -> Effort | str:
    """The effort of the jogged joint, or why it is unknown."""
    robot, joint = model.robot, travel.joint
    if np.isfinite(course.current[:, joint]).any():
        if np.all(robot.drive_gain == 1.0):
            return "the robot file has no drive gains ([drive] gain), so the torque is unknown"
        torque, source = robot.drive_gain[joint] * course.current[:, joint], "drive gain or current"
    elif np.isfinite(course.torque[:, joint]).any():
        # Torques are known at the joints; a coupled wrist transmits them to the motors.
        torque, source = (course.torque @ robot.to_motors.T)[:, joint], "the measured torque"
    else:
        return "the controller measures neither current nor torque"
    speed = course.speed[:, joint] * np.sign(travel.distance)
    there, back = (sign * speed >= STEADY * travel.speed for sign in (1.0, -1.0))
    known = np.isfinite(torque) & np.isfinite(course.position[:, joint])
    if min((there & known).sum(), (back & known).sum()) < 2 * BLOCKS:
        return "the joint was stopped before it returned, or its distance is too short for a constant speed"
    paces = [_pace(course, travel, rows) for rows in (there & known, back & known)]
    if max(abs(pace - 1.0) for pace in paces) > PACE + 0.5 * _speed_step(course, travel):
        return (
            f"the sampled speed is {paces[0]:.2f} of the commanded speed there and {paces[1]:.2f} back: the "
            "joint moves to each command in a step, and its current is not that of steady motion. Try a "
            "shorter cycle"
        )
    middle = np.nanmean(course.position[(there | back) & known], axis=0)
    unit = "N m" if robot.revolute[joint] else "N"
    positions = course.position[:, joint] - middle[joint]
    direction = np.sign(travel.distance)
    rows = [
        [1.0, position, sign * direction, value]
        for rows_of, sign in ((there & known, 1.0), (back & known, -1.0))
        for position, value in zip(_blocks(positions[rows_of]), _blocks(torque[rows_of]), strict=True)
    ]
    values, stds = _least_squares(np.array(rows))
    # The drive's torque against friction has the sign of the velocity.
    return Effort(values[0], stds[0], values[2], stds[2], middle, unit, source)


def _pace(course: Course, travel: Travel, rows: np.ndarray) -> float:
    """Mean measured speed as a share of the commanded speed; 1 if it is not measured."""
    measured = course.velocity[rows, travel.joint] / course.speed[rows, travel.joint]
    return float(np.nanmean(measured)) if np.isfinite(measured).any() else 1.0


def _speed_step(course: Course, travel: Travel) -> float:
    """Smallest difference between two measured speeds, as a share of the jog speed [-]."""
    values = course.velocity[:, travel.joint]
    steps = np.diff(np.unique(values[np.isfinite(values)]))
    return float(steps.min()) / travel.speed if len(steps) else 0.0


def _blocks(values: np.ndarray) -> np.ndarray:
    return np.array([part.mean() for part in np.array_split(values, BLOCKS)])


def _least_squares(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fit torque = level + slope * position + friction * direction; return the three and their stds."""
    matrix, torque = rows[:, :3], rows[:, 3]
    scale = np.maximum(np.abs(matrix).max(axis=0), 1e-12)
    values = np.linalg.lstsq(matrix / scale, torque, rcond=None)[0] / scale
    residual = torque - matrix @ values
    variance = residual @ residual / (len(torque) - 3)
    covariance = variance * np.linalg.pinv((matrix / scale).T @ (matrix / scale))
    return values, np.sqrt(np.diag(covariance)) / scale


def torque_at_rest(model: Model, positions: np.ndarray, payload: str = "") -> np.ndarray:
    """Torque of gravity, springs and balancers at the drives, shape (t, n) [N m], or [N] if prismatic."""
    still = np.zeros_like(positions)
    motion = Motion.of(np.arange(len(positions), dtype=float), positions, still, still, payload=payload)
    torque = model.torque(model.loaded(motion), model.nominal_values)
    at_drives: np.ndarray = torque @ model.robot.to_motors.T
    return at_drives


@dataclass(frozen=True)
class FlangeTravel:
    """Expected displacement of the flange in the base frame."""

    moved: np.ndarray  # displacement, shape (3,) [m]
    axis: np.ndarray  # axis about which the joint turns or along which it slides, shape (3,) [-]


def flange_travel(robot: Robot, position: np.ndarray, travel: Travel) -> FlangeTravel:
    """Displacement of the flange by the robot's geometry, from a position (n,) [rad] or [m]."""
    target = position.copy()
    target[travel.joint] += travel.distance
    flange = partial(flange_position, robot.kinematics, robot.flange)
    moved = flange(target) - flange(position)
    data = robot.kinematics.createData()
    jacobian = pin.computeJointJacobians(robot.kinematics, data, position)[:, travel.joint]
    return FlangeTravel(moved, jacobian[3:] if robot.revolute[travel.joint] else jacobian[:3])
