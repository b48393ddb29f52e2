r"""Threshold of contact as a rate of false alarms, from the residual of runs without contact; and alarms.

The standard deviation of each joint's residual depends on its speed and load,

.. math:: s^2 = c_0 + c_1 e^{-|\dot q| / v_0} + c_2 \dot q^2 + c_3 \tau^2, \qquad c \ge 0,

noise, stiction near rest, errors of viscous friction, and errors of gains and gravity. The score of a sample
is the largest :math:`|r_j| / s_j` of all joints. Its largest maxima over blocks of a second follow a
generalized Pareto distribution (Pickands 1975; Hosking, Wallis 1987, probability-weighted moments), which is
extrapolated to the level that one block in an hour exceeds.

Assumptions: contact-free runs are like those here in speed, load, temperature and payload; the tail is no
heavier than that of the maxima from which it was estimated; blocks are independent. The shape is at least 0
(an exponential tail), plus half of its standard deviation, :math:`1 / \sqrt{m}` for m maxima: a short
calibration gives a higher threshold, not more alarms. Drawn calibrations of 40 s to an hour, for one alarm an
hour, made 0.0 to 0.2 alarms an hour with normal residuals and 0.9 to 1.5 with Student's distribution of five
degrees of freedom.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy import optimize

from ..arm.robot import Robot
from ..errors import RecordingError
from .observer import Estimates
from .wrench import flange_wrenches

BLOCK = 1.0
"""Duration of a block, within which exceedances count as one alarm [s]."""
FEWEST = 20
"""Fewest blocks from which a tail is estimated."""
HEAVIEST = 0.5
"""Largest shape of the tail [-]: its variance is just infinite; residuals of an arm have a largest value."""
LARGEST, SHARES = 50.0, (0.1, 0.5)
"""Number of maxima that the tail describes, and limits of their share [-]: fewer would scatter more, and more
would not be a tail."""
ROUNDS = 3
"""Rounds of the weighted fit of the standard deviation; the weights change by some percent after two."""
HOUR = 3600.0


@dataclass(frozen=True, eq=False)
class Threshold:
    """Score above which a residual is a contact."""

    coefficients: np.ndarray  # coefficients c of each joint's variance, shape (n, 4)
    slow: np.ndarray  # speed within which stiction matters, v0, shape (n,) [rad/s]
    level: float  # score at the requested rate [-]
    alarms_per_hour: float  # requested rate of false alarms [1/h]
    hours: float  # duration of the runs from which it was computed [h]

    @classmethod
    def of(cls, runs: Sequence[Estimates], slow: np.ndarray, alarms_per_hour: float = 1.0) -> "Threshold":
        """Threshold from runs without contact that the fit has not used.

        Args:
            runs: Estimates along the runs.
            slow: Speed below which joints counted as standing in the fit, shape (n,) [rad/s].
            alarms_per_hour: Accepted false alarms [1/h].

        Raises:
            RecordingError: The runs are too short.
        """
        torque, velocity, load = (
            np.concatenate([getattr(run, name)[np.all(np.isfinite(run.torque), axis=1)] for run in runs])
            for name in ("torque", "velocity", "load")
        )
        if not len(torque):
            raise RecordingError("contact: the runs without contact have no usable samples")
        coefficients = np.array(
            [
                _variance(torque[:, j], _features(velocity[:, j], load[:, j], slow[j]))
                for j in range(len(slow))
            ]
        )
        draft = cls(coefficients, slow, np.inf, alarms_per_hour, 0.0)
        maxima = np.concatenate([block_maxima(run.time, draft.score(run)) for run in runs])
        if len(maxima) < FEWEST:
            raise RecordingError(
                f"contact: the runs without contact last {len(maxima) * BLOCK:g} s; at least "
                f"{FEWEST * BLOCK:g} s are needed for a threshold"
            )
        level = Tail.of(maxima).exceeded_by(alarms_per_hour * BLOCK / HOUR)
        return cls(coefficients, slow, level, alarms_per_hour, len(maxima) * BLOCK / HOUR)

    def scale(self, estimates: Estimates) -> np.ndarray:
        """Standard deviation of the residual without contact, shape (t, n) [N m]."""
        parts = zip(estimates.velocity.T, estimates.load.T, self.slow, self.coefficients, strict=True)
        return np.sqrt(np.stack([_features(v, load, slow) @ c for v, load, slow, c in parts], axis=1))

    def score(self, estimates: Estimates) -> np.ndarray:
        """Largest residual of all joints over its standard deviation, shape (t,) [-]; NaN if unknown."""
        return np.max(np.abs(estimates.torque) / self.scale(estimates), axis=1)

    def torque(self, estimates: Estimates) -> np.ndarray:
        """External torque at which each joint alone makes an alarm, shape (t, n) [N m]."""
        return self.level * self.scale(estimates)


def _features(velocity: np.ndarray, load: np.ndarray, slow: float) -> np.ndarray:
    """Terms of the variance, shape (t, 4)."""
    return np.stack([np.ones_like(velocity), np.exp(-np.abs(velocity) / slow), velocity**2, load**2], axis=1)


def _variance(residual: np.ndarray, features: np.ndarray) -> np.ndarray:
    """Coefficients of the variance, shape (4,), by weighted least squares on the squares of the residual.

    The square of a residual with variance s^2 scatters by about s^2, so it is weighted by 1 / s^2.
    """
    size = np.maximum(np.sqrt(np.mean(features**2, axis=0)), 1e-300)
    variance = np.full(len(residual), max(float(np.mean(residual**2)), 1e-300))
    floor = 1e-4 * variance[0]  # a hundredth of the usual residual: quieter samples do not decide
    for _ in range(ROUNDS):
        weight = 1.0 / np.maximum(variance, floor)
        coefficients, _ = optimize.nnls(features / size * weight[:, None], residual**2 * weight)
        variance = features / size @ coefficients
    coefficients = coefficients / size
    coefficients[0] = max(coefficients[0], floor)
    return np.asarray(coefficients)


def block_maxima(time: np.ndarray, score: np.ndarray) -> np.ndarray:
    """Largest score of each block of a run that is known in at least half of it, shape (b,)."""
    if not len(time):
        return np.zeros(0)
    blocks = ((time - time[0]) // BLOCK).astype(int)
    known = np.isfinite(score)
    maxima = np.full(blocks[-1] + 1, -np.inf)
    np.maximum.at(maxima, blocks[known], score[known])
    counts = np.bincount(blocks, minlength=len(maxima))
    return maxima[2 * np.bincount(blocks[known], minlength=len(maxima)) >= np.maximum(counts, 1)]


class Tail(NamedTuple):
    """Generalized Pareto distribution of the largest block maxima."""

    share: float  # share of the maxima that it describes [-]
    start: float  # score that this share exceeds [-]
    scale: float  # scale [-]
    shape: float  # shape, above 0 [-]

    @classmethod
    def of(cls, maxima: np.ndarray) -> "Tail":
        """Tail of block maxima (b,) by probability-weighted moments."""
        start = float(np.quantile(maxima, 1.0 - np.clip(LARGEST / len(maxima), *SHARES)))
        excess = np.sort(maxima[maxima > start] - start)
        m, mean = len(excess), float(excess.mean())
        # Mean of x (1 - F(x)), with plotting positions of Hosking and Wallis
        weighted = float(np.mean(excess * (1.0 - (np.arange(1, m + 1) - 0.35) / m)))
        ratio = mean / (mean - 2.0 * weighted) if mean > 2.0 * weighted else np.inf
        shape = float(np.clip(2.0 - ratio, 0.0, HEAVIEST)) if np.isfinite(ratio) else 0.0
        return cls(m / len(maxima), start, mean * (1.0 - shape), shape + 0.5 / np.sqrt(m))

    def exceeded_by(self, share: float) -> float:
        """Score that a share of the blocks exceeds, at least `start`."""
        ratio = min(share / self.share, 1.0)
        return self.start + self.scale * float(np.expm1(-self.shape * np.log(ratio))) / self.shape


@dataclass(frozen=True, eq=False)
class Alarm:
    """One contact: exceedances that are less than a block of the threshold apart."""

    start: float  # time of the first exceedance [s]
    end: float  # time of the last exceedance [s]
    joint: int  # index of the joint that exceeded its threshold the most, from 0
    torque: np.ndarray  # external torques at the highest score, shape (n,) [N m]
    position: np.ndarray  # joint positions there, shape (n,) [rad]
    scale: np.ndarray  # standard deviations of the torques without contact there, shape (n,) [N m]
    score: float  # highest score, over the level of the threshold [-]

    def wrench(self, robot: Robot) -> np.ndarray:
        """Force and moment on the flange at the highest score, in the axes of the base, (6,) [N, N m]."""
        return flange_wrenches(robot, self.position[None], self.torque[None], self.scale[None])[0]


@dataclass(eq=False)
class Alarms:
    """Collects alarms from estimates that come in pieces; a recording is one piece."""

    threshold: Threshold  # threshold
    ended: list[Alarm] = field(default_factory=list)  # alarms that have ended
    _open: Alarm | None = None

    @property
    def all(self) -> list[Alarm]:
        """All alarms, including the current one."""
        return [*self.ended, *([self._open] if self._open is not None else [])]

    def add(self, estimates: Estimates) -> None:
        """Take further estimates."""
        for alarm in self._exceedances(estimates):
            if self._open is not None and alarm.start - self._open.end < BLOCK:
                self._open = _joined(self._open, alarm)
            else:
                self._close()
                self._open = alarm
        if self._open is not None and len(estimates) and estimates.time[-1] - self._open.end >= BLOCK:
            self._close()

    def _close(self) -> None:
        if self._open is not None:
            self.ended.append(self._open)
        self._open = None

    def _exceedances(self, estimates: Estimates) -> Iterator[Alarm]:
        """Each sample above the threshold as an alarm of its own."""
        scale = self.threshold.scale(estimates)
        score = np.abs(estimates.torque) / scale
        with np.errstate(invalid="ignore"):
            rows = np.flatnonzero(score.max(axis=1) > self.threshold.level)
        for row in rows:
            time, joint = float(estimates.time[row]), int(np.argmax(score[row]))
            highest = float(score[row, joint]) / self.threshold.level
            parts = estimates.torque[row], estimates.position[row], scale[row]
            yield Alarm(time, time, joint, *parts, highest)


def _joined(first: Alarm, second: Alarm) -> Alarm:
    """One alarm for both, described by the higher of them."""
    top = first if first.score >= second.score else second
    return Alarm(first.start, second.end, top.joint, top.torque, top.position, top.scale, top.score)
