"""Joint numbers fitted by simulation: Gauss-Newton steps for all joints at once, each by its own error.

A number of one joint moves that joint far more than others. So one rollout with a number moved on every joint
gives its derivatives for all joints, and each joint keeps or refuses its own step. Coupling between joints
enters through the errors, which are those of the whole arm.

Where friction exceeds the torque of the bodies, a joint moves alike with all its torques scaled by one
factor. So steps are made in the stiffness and in the ratios of the other numbers to it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..export.changes import SAME
from ..fit.needed_changes import with_needed_changes
from ..fit.servo_fit import LONGEST
from .joint_numbers import ARMATURE, DAMPING, DELAY, DRY, KP, LIMIT
from .rollouts import MOMENTS, Rollouts

STEPS = 12
"""Maximum number of Gauss-Newton steps."""
ENOUGH = 0.004
"""Mean relative decrease of the squared errors of the joints below which no further step is made: delay,
damping and armature are nearly alike, so errors decrease slowly near the optimum."""
DAMPINGS = (1e-6, 1e-2, 1.0)
"""Damping of the steps that are tried together, relative to the information about each number."""
LARGEST = 1.0
"""Largest step of a logarithm."""
DIFFERENCE = 0.01
"""Step of a finite difference, in logarithms and relative to the size of other numbers."""
LATER = 5e-4
"""Step of a finite difference of a delay [s]: a part of a step of usual simulations."""
WIDE = np.log(10.0)
"""Prior standard deviation of logarithms: files are wrong by factors of ten."""
LATE = 0.02
"""Prior standard deviation of a delay [s]: a cycle of a usual bus."""
ALIKE = 0.1
"""Prior standard deviation of the logarithm of a servo's stiffness over that of the others."""
LOGARITHMIC = [KP, LIMIT]
"""Rows whose logarithm is fitted."""
SCALED = [DAMPING, DRY, ARMATURE]
"""Rows that are divided by the stiffness."""


class _Prior(NamedTuple):
    """Expected coordinates, NaN for those without expectation, and standard deviations, shape (6, n) each."""

    mean: np.ndarray
    deviation: np.ndarray

    def moved(self, point: np.ndarray) -> np.ndarray:
        """Distances from what is expected, in standard deviations, shape (6, n)."""
        return np.nan_to_num((point - self.mean) / self.deviation, posinf=0.0, neginf=0.0)


@dataclass(frozen=True, eq=False)
class Tuning:
    """Fit of joint numbers to the windows of runs."""

    rollouts: Rollouts  # windows of the runs
    file: np.ndarray  # numbers of the file, shape (6, n), towards which a weak prior pulls
    size: np.ndarray  # size of a number that shows in the motion of each joint, shape (6, n)
    floor: np.ndarray  # standard deviations because of sampling and steps, in coordinates, shape (6, n)
    # Numbers whose stiffness and delay are expected rather than those of the file, shape (6, n).
    expected: np.ndarray | None = None
    held: bool = False  # whether commands are held from sample to sample; otherwise they are interpolated

    def fitted(
        self, values: np.ndarray, free: np.ndarray, tied: Sequence[int] = (), most: int = STEPS
    ) -> np.ndarray:
        """Numbers of the least squared errors, shape (6, n), from `values`, of which only the `free` change.

        In the `tied` rows, all joints move by the same step; there are at most `most` steps.
        """
        point = to_ratios(to_coordinates(values), free)
        for _ in range(most):
            residual, jacobian = self._by_ratios(point, free)
            weights = self._weights(residual)
            prior = self._prior(point, free, tied)
            steps = self._steps(point, weights * residual, weights * jacobian, prior, _shares(free, tied))
            points = [point, *(self._bounded(point, step) for step in steps)]
            errors = weights * np.array(
                [residual, *self._errors([from_ratios(each, free) for each in points[1:]])]
            )
            squares = np.sum(errors**2, axis=1) + np.finfo(float).tiny
            costs = squares / squares[0] * len(self.rollouts)
            costs += [np.sum(prior.moved(each) ** 2, axis=0) for each in points]
            together = np.argmin(np.sum(np.log(costs), axis=1))
            chosen = np.full(costs.shape[1], together) if tied else np.argmin(costs, axis=0)
            point = np.array(points)[chosen, :, np.arange(costs.shape[1])].T
            if np.mean(np.log(np.take_along_axis(costs, chosen[None], axis=0) / costs[0])) > -ENOUGH:
                break
        return np.where(free, to_values(from_ratios(point, free)), values)

    def cost(self, values: np.ndarray) -> np.ndarray:
        """Logarithm of the usual error of each joint in a window, shape (n,)."""
        return np.asarray(np.log(np.mean(self.sizes(values), axis=0) + np.finfo(float).tiny))

    def sizes(self, values: np.ndarray) -> np.ndarray:
        """Rms error of each joint in each window, shape (w, n) [-]."""
        return np.asarray(np.sqrt(np.mean(self.rollouts.errors([values], self.held)[0] ** 2, axis=1)))

    def needed(self, values: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of which only those differ from the file that the runs require, and standard deviations.

        The standard deviations are those of coordinates, given that the other numbers are those of the file.
        """
        point, old, std = to_coordinates(values), to_coordinates(self.file), np.full(values.shape, np.inf)
        for joint, covariance in enumerate(self._covariances(point, free)):
            rows = np.flatnonzero(free[:, joint])
            if not len(rows):
                continue
            groups = [np.array([place]) for place in range(len(rows)) if np.isfinite(old[rows[place], joint])]
            reference = np.where(np.isfinite(old[rows, joint]), old[rows, joint], 0.0)
            point[rows, joint], after = with_needed_changes(point[rows, joint], covariance, reference, groups)
            std[rows, joint] = np.sqrt(np.diag(after))
        values = to_values(self._bounded(point, np.zeros(point.shape)))
        return np.where(np.isclose(point, old, rtol=SAME, atol=0.0), self.file, values), std

    def deviations(self, values: np.ndarray, free: np.ndarray) -> np.ndarray:
        """Standard deviations of coordinates if all free numbers are uncertain, shape (6, n)."""
        std = np.full(values.shape, np.inf)
        for joint, covariance in enumerate(self._covariances(to_coordinates(values), free)):
            std[free[:, joint], joint] = np.sqrt(np.diag(covariance))
        return std

    def _covariances(self, point: np.ndarray, free: np.ndarray) -> list[np.ndarray]:
        """Covariance of the free numbers of each joint: windows are independent samples."""
        residual, jacobian = self._linear(point, free)
        weights = self._weights(residual)
        residual, jacobian = weights * residual, weights * jacobian
        # Each number has the prior of one that is not scaled.
        deviation = self._prior(point, np.zeros(free.shape, bool)).deviation
        variance = np.sum(residual**2, axis=0) / len(self.rollouts) + np.finfo(float).tiny
        covariances = []
        for joint in range(point.shape[1]):
            rows = np.flatnonzero(free[:, joint])
            columns = jacobian[:, :, joint][rows].T
            products = columns * residual[:, joint, None]
            scores = products.reshape(len(self.rollouts), MOMENTS, len(rows)).sum(1)
            information = columns.T @ columns + variance[joint] * np.diag(deviation[rows, joint] ** -2.0)
            inverse = np.linalg.pinv(information, hermitian=True)
            count = len(self.rollouts) / max(len(self.rollouts) - len(rows), 1)
            sampled = count * inverse @ (scores.T @ scores) @ inverse
            covariances.append(sampled + np.diag(self.floor[rows, joint] ** 2))
        return covariances

    def _linear(self, point: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Errors (m, n), and their derivatives by each row of numbers (6, m, n)."""
        size = np.maximum(self.size * scale_of(point), np.abs(point))
        steps = DIFFERENCE * np.where(np.isin(ROWS, LOGARITHMIC), 1.0, size)
        steps[DELAY] = LATER
        rows = np.flatnonzero(free.any(axis=1))
        moved = [point + steps * (free & (ROWS == row)) for row in rows]
        errors = self._errors([point, *moved])
        jacobian = np.zeros((len(point), *errors[0].shape))
        for row, error in zip(rows, errors[1:], strict=True):
            jacobian[row] = (error - errors[0]) / steps[row] * free[row]
        return errors[0], jacobian

    def _by_ratios(self, point: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Errors at a point of ratios, and their derivatives by these."""
        natural, scaled = from_ratios(point, free), _scaled(free)
        residual, jacobian = self._linear(natural, free)
        jacobian[KP] += np.einsum("kj,kmj->mj", natural[SCALED], jacobian[SCALED]) * free[KP]
        jacobian[KP] += jacobian[LIMIT] * free[KP]
        jacobian[SCALED] *= np.where(scaled, scale_of(natural), 1.0)[SCALED][:, None]
        return residual, jacobian

    def _weights(self, residual: np.ndarray) -> np.ndarray:
        """Weights of errors (m, n), by which windows far beyond the usual error count less."""
        size = np.sqrt(np.mean(residual.reshape(len(self.rollouts), -1, residual.shape[1]) ** 2, axis=1))
        weights = 1.0 / np.sqrt(1.0 + size / (np.mean(size, axis=0) + np.finfo(float).tiny))
        return np.repeat(weights, len(residual) // len(weights), axis=0)

    def _steps(
        self,
        point: np.ndarray,
        residual: np.ndarray,
        jacobian: np.ndarray,
        prior: "_Prior",
        shares: np.ndarray,
    ) -> list[np.ndarray]:
        """Damped Gauss-Newton steps, shape (6, n) each."""
        weight = len(self.rollouts) / (np.sum(residual**2, axis=0) + np.finfo(float).tiny)
        count = point.shape[1]
        gradient = np.einsum("kmj,mj->kj", jacobian, residual) * weight + prior.moved(point) / prior.deviation
        blocks = np.einsum("kmj,lmj->jkl", jacobian, jacobian) * weight[:, None, None]
        information = np.zeros((6, count, 6, count))
        for joint in range(count):
            information[:, joint, :, joint] = blocks[joint] + np.diag(prior.deviation[:, joint] ** -2.0)
        matrix = shares.T @ information.reshape(6 * count, 6 * count) @ shares
        slope, diagonal = shares.T @ gradient.ravel(), np.diag(np.diag(matrix))
        steps = [np.linalg.solve(matrix + damping * diagonal, slope) for damping in DAMPINGS]
        return [-(shares @ step).reshape(point.shape) for step in steps]

    def _bounded(self, point: np.ndarray, step: np.ndarray) -> np.ndarray:
        new = point + step
        new[LOGARITHMIC] = point[LOGARITHMIC] + np.clip(step[LOGARITHMIC], -LARGEST, LARGEST)
        new[SCALED] = np.maximum(new[SCALED], 0.0)
        new[DELAY] = np.clip(new[DELAY], 0.0, LONGEST)
        return new

    def _prior(self, point: np.ndarray, free: np.ndarray, tied: Sequence[int] = ()) -> "_Prior":
        """What is expected of the coordinates before the runs."""
        old = to_ratios(to_coordinates(self.file), free)
        deviation = np.maximum(self.size * np.where(_scaled(free), 1.0, scale_of(point)), np.abs(old))
        deviation[LOGARITHMIC], deviation[DELAY] = WIDE, LATE
        if self.expected is not None:
            old[[KP, DELAY]] = to_coordinates(self.expected)[[KP, DELAY]]
            deviation[KP] = ALIKE
        # What all joints share is expected once, not once by each joint.
        deviation[list(tied)] *= np.sqrt(free.shape[1])
        return _Prior(np.where(free & np.isfinite(old), old, np.nan), deviation)

    def _errors(self, points: Sequence[np.ndarray]) -> np.ndarray:
        """Errors of all windows and moments, shape (v, m, n)."""
        errors = self.rollouts.errors([to_values(point) for point in points], self.held)
        return errors.reshape(len(points), -1, errors.shape[-1])


ROWS = np.arange(6)[:, None]


def to_coordinates(values: np.ndarray) -> np.ndarray:
    """Numbers with the logarithms of some rows, shape (6, n)."""
    point = np.array(values)
    with np.errstate(divide="ignore"):
        point[LOGARITHMIC] = np.log(values[LOGARITHMIC])
    return point


def to_values(point: np.ndarray) -> np.ndarray:
    """The inverse of `to_coordinates`."""
    values = np.array(point)
    values[LOGARITHMIC] = np.exp(point[LOGARITHMIC])
    return values


def scale_of(point: np.ndarray) -> np.ndarray:
    """Stiffness by which other numbers are divided, shape (n,); 1 without servos."""
    return np.where(np.isfinite(point[KP]), np.exp(point[KP]), 1.0)


def _scaled(free: np.ndarray) -> np.ndarray:
    """Which numbers are divided by the stiffness: free ones, where it is free too, shape (6, n)."""
    return np.asarray(free & free[KP] & np.isin(ROWS, [*SCALED, LIMIT]))


def to_ratios(point: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Coordinates of free numbers (6, n) with ratios to the stiffness."""
    scaled, ratios = _scaled(free), np.array(point)
    ratios[SCALED] = np.where(scaled, point / scale_of(point), point)[SCALED]
    ratios[LIMIT] -= np.where(scaled, np.log(scale_of(point)), 0.0)[LIMIT]
    return ratios


def from_ratios(ratios: np.ndarray, free: np.ndarray) -> np.ndarray:
    """The inverse of `to_ratios`."""
    scaled, point = _scaled(free), np.array(ratios)
    point[SCALED] = np.where(scaled, ratios * scale_of(ratios), ratios)[SCALED]
    point[LIMIT] += np.where(scaled, np.log(scale_of(ratios)), 0.0)[LIMIT]
    return point


def _shares(free: np.ndarray, tied: Sequence[int]) -> np.ndarray:
    """Steps of the numbers by those of the unknowns, of which joints share the tied ones, shape (6 n, u)."""
    columns = []
    for row in range(free.shape[0]):
        each = [np.arange(free.shape[1]) == joint for joint in np.flatnonzero(free[row])]
        for chosen in [free[row]] if row in tied and free[row].any() else each:
            column = np.zeros(free.shape)
            column[row, chosen] = 1.0
            columns.append(column.ravel())
    return np.stack(columns, axis=1) if columns else np.zeros((free.size, 0))
