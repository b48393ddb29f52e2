"""Friction of a joint over its velocity, as a fit has it."""

from dataclasses import replace

import numpy as np

from ...arm.motion import Motion
from ...fit.fit import Fit
from ...model import Model

ROOM_TEMPERATURE = 25.0
"""Temperature [degC] at which curves are drawn where friction depends on it."""
APPROACH = 1.0
"""Path [rad] on which a joint slides before its friction is looked at: far more than any presliding."""


def friction_curve(fit: Fit, joint: int, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Friction torque of one joint that slides alone and steadily, and its standard deviation.

    Friction is what sliding adds to the torque that does not pass the gear: offset, ripple and rotor
    inertia are then gone by themselves, and so is all that goes through the links. What depends on more
    than velocity is taken at mid-range, at its nominal load there, and at `ROOM_TEMPERATURE`.

    Args:
        fit: Whose friction.
        joint: Index of the joint.
        velocity: Shape (t,) [rad/s].

    Returns:
        Torque and standard deviation, each (t,) [N m].
    """
    gears = replace(fit.model, effects=tuple(e for e in fit.model.effects if not e.transmitted), stated={})
    names = [fit.base.parameters[column].name for column in fit.base.kept]
    kept = [names.index(name) for name in gears.names if name in names]
    columns = [place for place, name in enumerate(gears.names) if name in names]
    sliding = gears.regressor(_alone(fit.model, joint, velocity))
    standing = gears.regressor(_alone(fit.model, joint, np.zeros_like(velocity)))
    to_motor = fit.model.robot.to_motors[joint]
    rows = np.einsum("i,tip->tp", to_motor, (sliding - standing)[1::2, :, columns])
    covariance = fit.estimate.covariance[np.ix_(kept, kept)]
    variance = np.einsum("tp,pq,tq->t", rows, covariance, rows)
    return rows @ fit.estimate.values[kept], np.sqrt(np.maximum(variance, 0.0))


def _alone(model: Model, joint: int, velocity: np.ndarray) -> Motion:
    """One joint slides at velocities (t,), each reached after `APPROACH`; 2 t samples."""
    limits = model.robot.limits
    middle = (np.maximum(limits.position_lower, -np.pi) + np.minimum(limits.position_upper, np.pi)) / 2
    still = np.zeros((2 * len(velocity), model.robot.dof))
    position, speed = still + middle, still.copy()
    speed[:, joint] = np.repeat(velocity, 2)
    position[::2] -= APPROACH * np.sign(speed[::2])
    time = np.arange(len(still)) * 1.0
    warm = np.full_like(still, ROOM_TEMPERATURE)
    at_rest = model.loaded(Motion.of(time, position, still, still, temperature=warm))
    return replace(at_rest, velocity=speed)
