r"""Joints whose motion other masses explain much better than another stiffness of their servos.

The position error of a servo is its torque over its stiffness. With the bodies of the file, that is the
torque of all links times one number, beside friction. If it needs another number for each link, the file has
wrong masses, and a stiffness that is fitted would take their place.
"""

from collections.abc import Sequence

import numpy as np

from ..arm.motion import Motion
from ..model import Model
from ..recordings.recording import interpolated
from .replay import Run

BLOCKS = 25
"""Number of independent samples that a run counts as: errors are correlated over about a second."""
REVERSAL = 0.02
"""Velocity over which dry friction changes its sign, over the rms velocity of the joint."""
MOST = np.log(2.0)
"""Largest logarithm of a stiffness over the file's for which masses may stand: no file has half the mass."""


def joints_with_other_masses(runs: Sequence[Run], model: Model, delay: np.ndarray) -> np.ndarray:
    """Whether other masses explain the position errors of each joint much better, shape (n,).

    By the Bayesian information criterion, each link's mass counts as a number. The runs have commands, with a
    delay (n,) [s], and the model is the arm that the file describes.
    """
    parts = [_system(run, model, delay) for run in runs]
    error, friction, links = (np.concatenate(part) for part in zip(*parts, strict=True))
    doubtful = np.zeros(len(delay), bool)
    for joint in range(len(delay)):
        torques = links[:, joint][:, np.any(links[:, joint], axis=0)]
        one, each = (
            _residual(np.column_stack([friction[:, joint], columns]), error[:, joint])
            for columns in (torques.sum(axis=1), torques)
        )
        doubtful[joint] = each < one * BLOCKS ** (-(torques.shape[1] - 1.0) / BLOCKS)
    return doubtful


def _system(run: Run, model: Model, delay: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position errors (t, n), columns of friction and rotor (t, n, 4), and torques of links (t, n, l)."""
    assert run.command is not None
    command = interpolated(run.time[:, None] - delay, run.time, run.command)
    acceleration = np.gradient(run.velocity, run.time, axis=0)
    motion = Motion.of(run.time, run.position, run.velocity, acceleration)
    slow = REVERSAL * np.sqrt(np.mean(run.velocity**2, axis=0)) + np.finfo(float).tiny
    ones = np.ones_like(acceleration)
    friction = np.stack([np.tanh(run.velocity / slow), run.velocity, acceleration, ones], axis=2)
    links = [
        (effect.regressor(model.robot, motion) * values).reshape(*acceleration.shape, -1, 10).sum(axis=3)
        for effect, values in model.shares(model.nominal_values)
        if effect.of_links
    ]
    return command - run.position, friction, np.concatenate(links, axis=2)


def _residual(columns: np.ndarray, values: np.ndarray) -> float:
    """Mean square of what columns (t, k) leave of values (t,)."""
    columns = columns / np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    solution = np.linalg.lstsq(columns, values, rcond=None)[0]
    return float(np.mean((values - columns @ solution) ** 2))
