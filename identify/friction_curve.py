"""Friction of each joint over its velocity, as a fit has it."""

from dataclasses import replace

import numpy as np

from .fit import Fit
from .model import Model
from .motion import Motion

ROOM_TEMPERATURE = 25.0
"""Temperature [degC] at which curves are drawn where friction depends on it."""
APPROACH = 1.0
"""Path [rad] on which a joint slides before its friction is looked at: far more than any presliding."""


def friction_curve(fit: Fit, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Friction torque of each joint that moves alone and steadily, and its standard deviation.

    Friction is what velocity adds to the torque that does not pass the gear: offset, ripple and rotor
    inertia are then gone by themselves, and so is all that goes through the links. What depends on more
    than velocity is taken at mid-range, loaded as believed there, and at `ROOM_TEMPERATURE`.

    Args:
        fit: Whose friction.
        velocity: Shape (t, n) [rad/s].

    Returns:
        Torque and standard deviation, each (t, n) [N m].
    """
    gears = replace(
        fit.model, effects=tuple(e for e in fit.model.effects if not e.transmitted), stated={}
    )
    names = [fit.base.parameters[column].name for column in fit.base.kept]
    kept = [names.index(name) for name in gears.names if name in names]
    columns = [place for place, name in enumerate(gears.names) if name in names]
    standing = gears.regressor(_alone(fit.model, np.zeros_like(velocity), 0))
    torque, variance = np.zeros_like(velocity), np.zeros_like(velocity)
    covariance = fit.estimate.covariance[np.ix_(kept, kept)]
    to_motors = np.linalg.inv(fit.model.robot.coupling).T
    for joint in range(velocity.shape[1]):
        rows = (gears.regressor(_alone(fit.model, velocity, joint)) - standing)[1::2, :, columns]
        row = np.einsum("i,tip->tp", to_motors[joint], rows)
        torque[:, joint] = row @ fit.estimate.values[kept]
        variance[:, joint] = np.einsum("tp,pq,tq->t", row, covariance, row)
    return torque, np.sqrt(np.maximum(variance, 0.0))


def partial_residual(fit: Fit, velocity: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Measured torque minus everything but friction, shape (t, n) [N m].

    What the model leaves plus the friction that it has: points that leave the curve of
    `friction_curve` show where its form is wrong.
    """
    return residual + friction_curve(fit, velocity)[0]


def _alone(model: Model, velocity: np.ndarray, joint: int) -> Motion:
    """One joint slides at its velocities (t, n), each reached after `APPROACH`; shape (2 t, n)."""
    robot = model.robot
    twice = np.repeat(velocity * (np.arange(robot.dof) == joint), 2, axis=0)
    lower = np.maximum(robot.limits.position_lower, -np.pi)
    upper = np.minimum(robot.limits.position_upper, np.pi)
    still = np.zeros_like(twice)
    position = still + (lower + upper) / 2
    position[::2] -= APPROACH * np.sign(twice[::2])
    time = np.arange(len(twice)) * 1.0
    warm = np.full_like(twice, ROOM_TEMPERATURE)
    at_rest = model.loaded(Motion.of(time, position, still, still, temperature=warm))
    return replace(at_rest, velocity=twice)
