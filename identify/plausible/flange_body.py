"""A body on the flange in some runs: one that nobody stated, or that the runs contradict.

The arm's own bodies are free and common to all runs; the body is what one run needs beside them.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arm.rigid_regressor import INERTIAL, body_regressor, rigid_regressor
from ..model import Model
from .block_prediction import BlockPrediction
from .described_bodies import Stated
from .evidence import RESOLVED
from .samples import Sampled, joined

MASS, MOMENTS = INERTIAL.index("M"), [INERTIAL.index(name) for name in ("MX", "MY", "MZ")]
HELD_BACK = 1e-7
"""Variance of the noise over that of a column: numbers that nothing tells apart stay small."""


class FlangeBody(NamedTuple):
    """A body on the flange.

    Attributes:
        gain: Log-likelihood by which it explains its run better than no body does.
        mass: [kg].
        mass_std: Standard deviation [kg].
        center: Center of mass from the flange's origin, in its axes, shape (3,) [m].
        center_std: Shape (3,) [m].
    """

    gain: float
    mass: float
    mass_std: float
    center: np.ndarray
    center_std: np.ndarray


def flange_body(model: Model, logs: Sequence[Sampled], loaded: int) -> FlangeBody:
    """The body that one of several runs carries beside what all carry; efforts are torques."""
    log = joined(logs)
    begin = sum(len(other.effort) for other in logs[:loaded])
    rows = slice(begin, begin + len(logs[loaded].effort))
    robot = model.robot
    stated = Stated.of(model, log.motion).columns
    columns = np.concatenate([rigid_regressor(robot.kinematics, log.motion), stated], axis=2)
    body = np.zeros((*log.effort.shape, len(INERTIAL)))
    body[rows] = body_regressor(robot.kinematics, log.motion[rows], robot.flange)
    every = np.concatenate([body, columns], axis=2)
    without, beside = BlockPrediction.of(columns, log), BlockPrediction.of(every, log)
    left = [np.log(prediction.coupled(log.effort) + RESOLVED) for prediction in (without, beside)]
    gain = float(0.5 * log.pieces @ (left[0] - left[1]))
    values, covariance = _fitted(every, beside, log)
    mass, moments = values[MASS], values[MOMENTS]
    if mass == 0.0:  # no motion shows one
        return FlangeBody(gain, 0.0, np.inf, np.zeros(3), np.full(3, np.inf))
    slope = np.zeros((3, len(values)))
    slope[range(3), MOMENTS], slope[:, MASS] = 1.0 / mass, -moments / mass**2
    center_std = np.sqrt(np.einsum("ap,pq,aq->a", slope, covariance, slope))
    mass_std = float(np.sqrt(covariance[MASS, MASS]))
    return FlangeBody(gain, float(mass), mass_std, moments / mass, center_std)


def _fitted(columns: np.ndarray, prediction: BlockPrediction, log: Sampled) -> tuple[np.ndarray, np.ndarray]:
    """Values of the flange's body and their covariance, by least squares of all joints."""
    sliding = log.sliding.astype(float)
    effort = (log.effort - log.effort.mean(axis=0)) * sliding
    n, count = effort.shape[1], prediction.terms.shape[2]
    level = np.sqrt(np.maximum(prediction.coupled(log.effort), 1e-6)) * effort.std(axis=0)
    blocks = []
    for j in range(n):
        own = np.zeros((len(effort), n * count))
        own[:, j * count : (j + 1) * count] = prediction.terms[j]
        blocks.append(np.column_stack([columns[:, j] * sliding[:, j : j + 1], own, effort[:, j]]) / level[j])
    matrix = np.concatenate(blocks)
    size = np.sqrt((matrix[:, :-1] ** 2).sum(axis=0))
    kept = size > 0
    scaled = matrix[:, :-1][:, kept] / size[kept]
    inverse = np.linalg.inv(scaled.T @ scaled + HELD_BACK * np.eye(scaled.shape[1]))
    solution = inverse @ (scaled.T @ matrix[:, -1])
    rest = matrix[:, -1] - scaled @ solution
    # Samples say as much as that many independent ones.
    variance = float(rest @ rest) / max(float(log.pieces.sum()), 1.0)
    body = np.flatnonzero(kept[: len(INERTIAL)])
    values, covariance = np.zeros(len(INERTIAL)), np.zeros((len(INERTIAL), len(INERTIAL)))
    values[body] = solution[: len(body)] / size[body]
    inverse = inverse[: len(body), : len(body)]
    covariance[np.ix_(body, body)] = variance * inverse / np.outer(size[body], size[body])
    return values, covariance
