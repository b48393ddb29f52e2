"""Estimate of a payload in one of several runs.

The bodies of the arm are free and common to all runs; the payload is the additional body that one run needs.
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
"""Ridge parameter, noise variance over column variance: values that no data distinguish stay small."""


class FlangeBody(NamedTuple):
    """A body on the flange.

    Attributes:
        gain: Increase in log-likelihood of the run compared with no payload.
        mass: Mass [kg].
        mass_std: Standard deviation of the mass [kg].
        center: Center of mass in the flange frame, shape (3,) [m].
        center_std: Standard deviation of the center of mass, shape (3,) [m].
    """

    gain: float
    mass: float
    mass_std: float
    center: np.ndarray
    center_std: np.ndarray


def flange_body(model: Model, logs: Sequence[Sampled], loaded: int) -> FlangeBody:
    """Payload that run `loaded` carries in addition to what all runs carry; efforts are torques."""
    log = joined(logs)
    begin = sum(len(other.effort) for other in logs[:loaded])
    rows = slice(begin, begin + len(logs[loaded].effort))
    robot = model.robot
    stated = Stated.of(model, log.motion).columns
    columns = np.concatenate([rigid_regressor(robot.kinematics, log.motion), stated], axis=2)
    body = np.zeros((*log.effort.shape, len(INERTIAL)))
    body[rows] = body_regressor(robot.kinematics, log.motion[rows], robot.flange)
    all_columns = np.concatenate([body, columns], axis=2)
    without, with_body = BlockPrediction.of(columns, log), BlockPrediction.of(all_columns, log)
    losses = [np.log(prediction.coupled(log.effort) + RESOLVED) for prediction in (without, with_body)]
    gain = float(0.5 * log.pieces @ (losses[0] - losses[1]))
    values, covariance = _fitted(all_columns, with_body, log)
    mass, moments = values[MASS], values[MOMENTS]
    if mass == 0.0:  # the motion does not reveal a mass
        return FlangeBody(gain, 0.0, np.inf, np.zeros(3), np.full(3, np.inf))
    slope = np.zeros((3, len(values)))
    slope[range(3), MOMENTS], slope[:, MASS] = 1.0 / mass, -moments / mass**2
    center_std = np.sqrt(np.einsum("ap,pq,aq->a", slope, covariance, slope))
    mass_std = float(np.sqrt(covariance[MASS, MASS]))
    return FlangeBody(gain, float(mass), mass_std, moments / mass, center_std)


def _fitted(columns: np.ndarray, prediction: BlockPrediction, log: Sampled) -> tuple[np.ndarray, np.ndarray]:
    """Parameters of the payload and their covariance, by least squares over all joints."""
    sliding = log.sliding.astype(float)
    effort = (log.effort - log.effort.mean(axis=0)) * sliding
    n, count = effort.shape[1], prediction.terms.shape[2]
    level = np.sqrt(np.maximum(prediction.coupled(log.effort), 1e-6)) * effort.std(axis=0)
    blocks = []
    for j in range(n):
        terms = np.zeros((len(effort), n * count))
        terms[:, j * count : (j + 1) * count] = prediction.terms[j]
        bodies = columns[:, j] * sliding[:, j : j + 1]
        blocks.append(np.column_stack([bodies, terms, effort[:, j]]) / level[j])
    matrix = np.concatenate(blocks)
    size = np.sqrt((matrix[:, :-1] ** 2).sum(axis=0))
    nonzero = size > 0
    scaled = matrix[:, :-1][:, nonzero] / size[nonzero]
    inverse = np.linalg.inv(scaled.T @ scaled + HELD_BACK * np.eye(scaled.shape[1]))
    solution = inverse @ (scaled.T @ matrix[:, -1])
    residual = matrix[:, -1] - scaled @ solution
    # The number of independent samples determines the variance.
    variance = float(residual @ residual) / max(float(log.pieces.sum()), 1.0)
    body = np.flatnonzero(nonzero[: len(INERTIAL)])
    values, covariance = np.zeros(len(INERTIAL)), np.zeros((len(INERTIAL), len(INERTIAL)))
    values[body] = solution[: len(body)] / size[body]
    inverse = inverse[: len(body), : len(body)]
    covariance[np.ix_(body, body)] = variance * inverse / np.outer(size[body], size[body])
    return values, covariance
