"""What an oracle that knows the effect could find: its torque beyond what the owner's priors can take up.

Deviations of all nominal parameters, each within its tolerance, are fitted to the effect's torque. What is
left over is what shows the effect; half its squared length over the noise is the log-likelihood it gains.
"""

from typing import NamedTuple

import numpy as np

from .plant.body import inverse_dynamics, turn
from .plant.closed_loop import RATE, Log
from .plant.jit import njit
from .recordings.record import low_pass, rms
from .robots.robot import Robot

EVERY = 10
"""Samples of the log to one of the comparison: 50 Hz carries what is below 25 Hz."""
DENSER = 3.0
"""Density of the noise below 2 Hz, where most effects are, over its mean below 25 Hz."""
FREE = 1e3
"""Noise floors by which an offset of which nothing is known may be off."""


class Seen(NamedTuple):
    """A run without the effect, and the torque (t, n) [N m] that the effect adds to it."""

    log: Log
    torque: np.ndarray


@njit(cache=True)
def torques(body, position, velocity, acceleration):
    """Inverse dynamics of a motion, (t, n) [N m]."""
    torque, pull = np.empty_like(position), np.zeros(3)
    turned = np.empty((position.shape[1], 3, 3))
    for k in range(len(position)):
        turn(body.rotation, position[k], turned)
        inverse_dynamics(body, turned, velocity[k], acceleration[k], -body.gravity, pull, torque[k])
    return torque


def leeway(robot: Robot, log: Log) -> list[np.ndarray]:
    """Torques (t, n) by which nominal parameters may be off, each at its tolerance [N m]."""
    prior, n = robot.prior, robot.arm.joints
    position = low_pass(log.position)
    velocity = np.gradient(position, 1.0 / RATE, axis=0)
    acceleration = np.gradient(velocity, 1.0 / RATE, axis=0)
    columns = _inertial(robot, position, velocity, acceleration)
    tolerance = prior.inertial_tolerance
    for joint in range(n):
        sign = np.tanh(velocity[:, joint] / 0.003)
        own = [
            tolerance * prior.rotor[joint] * acceleration[:, joint],
            0.2 * prior.viscous[joint] * velocity[:, joint],
            0.2 * prior.coulomb[joint] * sign,
            prior.gain_tolerance * log.command[:, joint],
            FREE * robot.recorder.floor[joint] * prior.terms["offset"][joint] * np.ones(len(sign)),
        ]
        for column in own:
            columns.append(np.zeros_like(velocity))
            columns[-1][:, joint] = column
    return columns


def _inertial(
    robot: Robot, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
) -> list[np.ndarray]:
    """Torques of the ten parameters of every link, each off by its tolerance, (t, n) [N m]."""
    body, tolerance, columns = robot.prior.body, robot.prior.inertial_tolerance, []
    nothing = body._replace(mass=0.0 * body.mass, inertia=0.0 * body.inertia)
    size = np.sqrt(np.trace(body.inertia, axis1=1, axis2=2) / body.mass)
    for link in range(robot.arm.joints):
        # A pair of opposite masses is a first moment; a cross of inertia is itself.
        for k in range(3):
            moved = body.com.copy()
            moved[link, k] += 0.5 * tolerance * size[link]
            columns.append(_difference(body, body._replace(com=moved), position, velocity, acceleration))
        mass, inertia = nothing.mass.copy(), nothing.inertia.copy()
        mass[link] = tolerance * body.mass[link]
        columns.append(torques(nothing._replace(mass=mass), position, velocity, acceleration))
        for a in range(3):
            for b in range(a, 3):
                cross = inertia.copy()
                cross[link, a, b] = cross[link, b, a] = tolerance * np.trace(body.inertia[link]) / 3.0
                columns.append(torques(nothing._replace(inertia=cross), position, velocity, acceleration))
    return columns


def _difference(one, other, position, velocity, acceleration):  # type: ignore[no-untyped-def]
    return torques(other, position, velocity, acceleration) - torques(one, position, velocity, acceleration)


def beyond_prior(robot: Robot, seen: list[Seen], noise: np.ndarray) -> tuple[np.ndarray, float]:
    """What of an effect's torque the nominal parameters cannot take up.

    Args:
        robot: With the effect's owner's priors.
        seen: Runs without it, and its torque in them.
        noise: Noise floor below the filter, (n,) [N m].

    Returns:
        Its rms over the noise floor on every joint, (n,), and the gain in chi-squared by knowing it.
    """
    # Runs of one length are stacked; every joint is weighted by its noise.
    torque = np.concatenate([low_pass(run.torque)[::EVERY] for run in seen]) / noise
    columns = [leeway(robot, run.log) for run in seen]
    joined = [
        np.concatenate([low_pass(part)[::EVERY] for part in parts]) for parts in zip(*columns, strict=True)
    ]
    stacked = np.stack([column / noise for column in joined], axis=-1)
    matrix, target = stacked.reshape(-1, stacked.shape[-1]), torque.ravel()
    normal = matrix.T @ matrix + DENSER * np.eye(matrix.shape[1])  # warnings have unit variance
    values = np.linalg.solve(normal, matrix.T @ target)
    left = target - matrix @ values
    return rms(left.reshape(torque.shape)), float(left @ left / DENSER + values @ values)
