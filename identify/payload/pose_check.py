"""Check of a payload: the torque in two poses whose samples were left out of the estimate.

Of all windows of about a second in the runs with the payload, the two are chosen in which its torque differs
most, so that a wrong mass, center or gain shows. The payload is estimated again without them, and the mean
torque in each window is predicted. A wrong arm, a contact or a payload that moves appears here, even if it
agrees with the other samples.
"""

from dataclasses import dataclass, replace
from itertools import combinations
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
    """Mean torque in one window that was not used."""

    position: np.ndarray  # mean joint positions, shape (n,) [rad]
    # Measured torque beyond that of the arm, that is, of the payload, shape (n,) [N m]; NaN if a joint hardly
    # moves there.
    measured: np.ndarray
    predicted: np.ndarray  # predicted torque of the payload, shape (n,) [N m]
    std: np.ndarray  # standard deviation of the difference, shape (n,) [N m]

    @property
    def difference(self) -> np.ndarray:
        """Measured minus predicted torque, shape (n,) [N m]."""
        return self.measured - self.predicted


@dataclass(frozen=True, eq=False)
class Check:
    """Result of the check."""

    poses: tuple[PoseCheck, ...]  # poses that were not used; empty if the run is too short
    passed: bool  # whether all differences are within what noise and uncertainty allow
    limit: float  # largest allowed difference in standard deviations

    @property
    def worst(self) -> float:
        """Largest difference in standard deviations; 0 without poses."""
        ratios = [np.abs(pose.difference / pose.std) for pose in self.poses]
        return float(np.nanmax(ratios)) if ratios and not np.all(np.isnan(ratios)) else 0.0


def check_poses(rows: Rows, known: Known, position: np.ndarray, full: Posterior) -> Check:
    """Predict two windows from all others, from joint positions (r, n) [rad] and the estimate of all rows."""
    windows = _windows(rows)
    pair = _most_different(rows, full, windows)
    if pair is None:
        return Check((), True, np.inf)
    weight = rows.equations.weight.copy()
    for window in pair:
        weight[window] = 0.0
    part = replace(rows, equations=replace(rows.equations, weight=weight))
    left_out = posterior(part, known)
    others = [window for window in windows if not any(_overlap(window, pose) for pose in pair)]
    noise = _noise_of_means(part, left_out, others)
    poses = tuple(_pose(rows, left_out, noise, position, window) for window in pair)
    count = sum(np.count_nonzero(np.isfinite(pose.measured)) for pose in poses)
    freedom = max(len(others) // 2, 1)  # windows overlap by half
    limit = float(stats.t.isf(CHANCE / (2 * max(count, 1)), freedom))
    check = Check(poses, True, limit)
    return replace(check, passed=check.worst <= limit)


def _overlap(first: slice, second: slice) -> bool:
    return first.start < second.stop and second.start < first.stop


def _mean(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Weighted mean over time of (t, n) or (t, n, k); zero for a joint without weight."""
    shaped = weight.reshape(*weight.shape, *(1,) * (values.ndim - 2))
    return np.asarray(np.sum(shaped * values, axis=0) / np.maximum(np.sum(shaped, axis=0), 1.0))


def _noise_of_means(rows: Rows, fit: Posterior, windows: list[slice]) -> np.ndarray:
    """Standard deviation of the mean residual of a window, shape (n,) [N m].

    It is that between the other windows, which includes what the model of the arm lacks, and at least that of
    noise with the density near zero frequency.
    """
    weight = rows.equations.weight
    means = np.array([_mean(fit.residual[w], weight[w]) for w in windows]).reshape(-1, weight.shape[1])
    counts = np.array([np.sum(weight[w], axis=0) for w in windows]).reshape(means.shape)
    used = counts >= FEWEST
    usual = np.maximum(np.sum(used, axis=0), 1)
    between = np.sqrt(np.sum(np.where(used, means, 0.0) ** 2, axis=0) / usual)
    samples = np.sum(np.where(used, counts, 0.0), axis=0) / usual
    return np.maximum(between, fit.noise * np.minimum(1.0, fit.slow / np.sqrt(np.maximum(samples, 1.0))))


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
    apart = [(a, b) for a, b in combinations(range(len(usable)), 2) if not _overlap(usable[a], usable[b])]
    best = max(apart, key=distance.__getitem__, default=None)
    return (usable[best[0]], usable[best[1]]) if best is not None and distance[best] > 0.0 else None


def _pose(rows: Rows, fit: Posterior, noise: np.ndarray, position: np.ndarray, window: slice) -> PoseCheck:
    """Comparison in one window."""
    weight = rows.equations.weight[window]
    enough = weight.sum(axis=0) >= FEWEST
    jacobian = _mean(fit.jacobian[window], weight)
    std = np.sqrt(np.einsum("nk,kl,nl->n", jacobian, fit.covariance, jacobian) + noise**2)
    predicted = jacobian[:, rows.payload] @ fit.payload
    measured = np.where(enough, predicted + _mean(fit.residual[window], weight), np.nan)
    return PoseCheck(np.mean(position[window], axis=0), measured, predicted, std)
