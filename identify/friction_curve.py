"""Friction of each joint over its velocity, as a fit has it."""

from dataclasses import replace

import numpy as np

from .fit import Fit
from .model import Model
from .motion import Motion

ROOM_TEMPERATURE = 25.0
"""Temperature [degC] at which curves are drawn where friction depends on it."""


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
    moving = _steady(fit.model, velocity)
    standing = _steady(fit.model, np.zeros_like(velocity))
    torque, variance = np.zeros_like(velocity), np.zeros_like(velocity)
    covariance = fit.estimate.covariance[np.ix_(kept, kept)]
    to_motors = np.linalg.inv(fit.model.robot.coupling).T
    for joint in range(velocity.shape[1]):
        alone = replace(moving, velocity=velocity * (np.arange(velocity.shape[1]) == joint))
        rows = (gears.regressor(alone) - gears.regressor(standing))[:, :, columns]
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


def _steady(model: Model, velocity: np.ndarray) -> Motion:
    """Mid-range positions, believed load and room temperature at the given velocities (t, n)."""
    limits = model.robot.limits
    middle = (np.maximum(limits.position_lower, -np.pi) + np.minimum(limits.position_upper, np.pi)) / 2
    position = np.broadcast_to(middle, velocity.shape)
    time = np.arange(len(velocity)) * 1.0
    still = np.zeros_like(velocity)
    warm = np.full_like(velocity, ROOM_TEMPERATURE)
    at_rest = model.loaded(Motion.of(time, position, still, still, temperature=warm))
    return replace(at_rest, velocity=velocity)
