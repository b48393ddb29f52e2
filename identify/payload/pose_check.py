"""Check of a payload: the torque in two poses whose samples were left out of the estimate.

Of all windows of about a second in the runs with the payload, the two are chosen in which its torque differs
most, so that a wrong mass, center or gain shows. The payload is estimated again without them, and the mean
torque in each window is predicted. A wrong arm, a contact or a payload that moves appears here, even if it
agrees with the other samples.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy import stats

from .estimate import Posterior, posterior
from .known import Known
from .rows import Rows

WINDOW = 1.0
"""Duration of a window [s]: long enough for the mean to be well below the noise, short enough for a pose."""
SHARE = 0.1
"""Largest share of the run in one window: at least eight tenths remain for the estimate."""
FEWEST = 4
"""Least samples of a joint in a window for a mean."""
CHANCE = 0.01
"""Probability that a right payload fails the check, over both poses and all joints."""


class PoseCheck(NamedTuple):
    """Mean torque in one window that was not used.

    Attributes:
        position: Mean joint positions, shape (n,) [rad].
        measured: Measured torque beyond that of the arm, that is, of the payload, shape (n,) [N m]; NaN if a
            joint hardly moves there.
        predicted: Predicted torque of the payload, shape (n,) [N m].
        std: Standard deviation of the difference, shape (n,) [N m].
    """

    position: np.ndarray
    measured: np.ndarray
    predicted: np.ndarray
    std: np.ndarray

    @property
    def difference(self) -> np.ndarray:
        """Measured minus predicted torque, shape (n,) [N m]."""
        return self.measured - self.predicted


@dataclass(frozen=True, eq=False)
class Check:
    """Result of the check.

    Attributes:
        poses: Poses that were not used; empty if the run is too short.
        passed: Whether all differences are within what noise and uncertainty allow.
        limit: Largest allowed difference in standard deviations.
    """

    poses: tuple[PoseCheck, ...]
    passed: bool
    limit: float

    @property
    def worst(self) -> float:
        """Largest difference in standard deviations; 0 without poses."""
        ratios = [np.abs(pose.difference / pose.std) for pose in self.poses]
        return float(np.nanmax(ratios)) if ratios and not np.all(np.isnan(ratios)) else 0.0


def check_poses(rows: Rows, known: Known, position: np.ndarray, full: Posterior) -> Check:
    """Predict two windows from all others.

    Args:
        rows: Equations of all runs.
        known: Prior of the unknowns.
        position: Joint positions at the rows, shape (r, n) [rad].
        full: Estimate from all rows.
    """
    windows = _windows(rows)
    pair = _most_different(rows, full, windows)
    if pair is None:
        return Check((), True, np.inf)
    weight = rows.equations.weight.copy()
    for window in pair:
        weight[window] = 0.0
    part = replace(rows, equations=replace(rows.equations, weight=weight))
    left_out = posterior(part, known)
    poses = tuple(_pose(rows, left_out, position, window) for window in pair)
    count = sum(np.count_nonzero(np.isfinite(pose.measured)) for pose in poses)
    limit = float(stats.norm.isf(CHANCE / (2 * max(count, 1))))
    check = Check(poses, True, limit)
    return replace(check, passed=check.worst <= limit)


def _windows(rows: Rows) -> list[slice]:
    """Windows of the runs with the payload in which most joints slide."""
    equations, windows = rows.equations, []
    for run in equations.runs:
        length = run.stop - run.start
        size = int(min(WINDOW * equations.rate, SHARE * length))
        if rows.loaded[run.start] and size >= FEWEST:
            windows += [slice(a, a + size) for a in range(run.start, run.stop - size + 1, max(size // 2, 1))]
    return windows


def _most_different(rows: Rows, full: Posterior, windows: list[slice]) -> tuple[slice, slice] | None:
    """The two windows whose payload torques differ most, in units of the noise."""
    usable = [w for w in windows if np.all(np.sum(rows.equations.weight[w] > 0.0, axis=0) >= FEWEST)]
    usable = usable if len(usable) > 1 else windows
    if len(usable) < 2:
        return None
    body = rows.equations.regressor[:, :, rows.payload] @ full.payload / (full.noise * full.slow)
    means = np.array([np.mean(body[w], axis=0) for w in usable])
    distance = np.linalg.norm(means[:, None] - means[None], axis=2)
    for a, first in enumerate(usable):
        for b, second in enumerate(usable):
            if first.start < second.stop and second.start < first.stop:
                distance[a, b] = -1.0
    best = divmod(int(np.argmax(distance)), len(usable))
    return (usable[best[0]], usable[best[1]]) if distance[best] > 0.0 else None


def _pose(rows: Rows, fit: Posterior, position: np.ndarray, window: slice) -> PoseCheck:
    """Comparison in one window."""
    weight = rows.equations.weight[window]
    counts = weight.sum(axis=0)
    enough = counts >= FEWEST

    def mean(values: np.ndarray) -> np.ndarray:
        shaped = weight if values.ndim == 2 else weight[:, :, None]
        size = np.maximum(counts, 1.0) if values.ndim == 2 else np.maximum(counts, 1.0)[:, None]
        return np.asarray(np.sum(shaped * values[window], axis=0) / size)

    jacobian = mean(fit.jacobian)
    # The mean of n samples of noise that is `slow` times as large near zero frequency.
    noise = fit.noise * np.minimum(1.0, fit.slow / np.sqrt(np.maximum(counts, 1.0)))
    std = np.sqrt(np.einsum("nk,kl,nl->n", jacobian, fit.covariance, jacobian) + noise**2)
    predicted = jacobian[:, rows.payload] @ fit.payload
    measured = np.where(enough, predicted + mean(fit.residual), np.nan)
    return PoseCheck(np.mean(position[window], axis=0), measured, predicted, std)
