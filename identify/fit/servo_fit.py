r"""Identification of the law of position servos from commands, positions and torque.

The law of a joint, solved for the position error, is linear in its coefficients for a delay d,

.. math:: c(t - d) - q = \alpha \tau + \beta \dot q - \varphi \dot c(t - d) - \iota \int (c(t - d) - q)\, dt
    + \gamma, \quad k_p = 1 / \alpha, \; k_v = \beta / \alpha, \ldots

In this form the noise is that of the encoder. Solved for the torque, the law of a stiff servo would multiply
that noise by its gain. The delay is found by a search for the least residual.
Noise of the torque would make :math:`\alpha` too small and so the gains too large. Its variance is known from
the band that the low-pass removes, and is taken out of the normal equations.
All signals pass the same low-pass, which leaves a linear law as it is; samples at the limit of the torque are
left out. Standard deviations allow for correlated residuals, since scores are summed over blocks.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar
from scipy.stats import norm

from ..arm.motion import differentiate
from ..arm.robot import ServoLaw
from ..preparation.even import Even
from ..preparation.filters import low_pass
from ..preparation.spectra import position_cutoff
from ..recordings.recording import Recording

LONGEST = 0.15
"""Longest delay of a command that is considered [s]: five cycles of a 30 Hz bus."""


@dataclass(frozen=True, eq=False)
class ServoRun:
    """Signals of one run; n joints."""

    rate: float  # sampling rate [Hz]
    cutoff: float  # cut-off of the low-pass that all signals but `raw_torque` have passed [Hz]
    position: np.ndarray  # positions, shape (t, n) [rad]
    velocity: np.ndarray  # velocities, shape (t, n) [rad/s]
    torque: np.ndarray  # torques, shape (t, n) [N m]
    raw_torque: np.ndarray  # torques before the low-pass, shape (t, n) [N m]
    noise: np.ndarray  # standard deviation of the noise that is left in `torque`, shape (n,) [N m]
    command: CubicSpline  # commands as functions of the time since the first sample

    @classmethod
    def of(cls, recording: Recording, gain: np.ndarray) -> "ServoRun":
        """Signals of a recording with commands and effort; `gain` (n,) is the torque per current [N m/A]."""
        even = Even.of(recording, None)
        cutoff = position_cutoff(even.position, even.rate)
        position, command, torque = (
            low_pass(values, even.rate, cutoff)
            for values in (even.position, even.signal("command"), even.signal(even.measures))
        )
        scale = np.ones(len(gain)) if even.measures == "torque" else gain
        torque, raw_torque = scale * torque, scale * even.signal(even.measures)
        # White noise behind a low-pass follows from the part that it removed. The median leaves out jumps of
        # friction, which a low-pass removes too.
        removed, share = raw_torque - torque, cutoff / (0.5 * even.rate)
        size = np.median(np.abs(removed - np.median(removed, axis=0)), axis=0) / norm.ppf(0.75)
        noise = size * np.sqrt(share / max(1.0 - share, share))
        velocity = differentiate(position, even.rate)[0]
        commands = CubicSpline(even.time - even.time[0], command)
        return cls(even.rate, cutoff, position, velocity, torque, raw_torque, noise, commands)

    @property
    def inside(self) -> slice:
        """Samples away from the transients of the filters, thinned to the band of the low-pass."""
        edge = int(self.rate * (LONGEST + 2.0 / self.cutoff))
        return slice(edge, len(self.position) - edge, max(1, int(self.rate / (4.0 * self.cutoff))))

    @property
    def time(self) -> np.ndarray:
        """Time since the first sample, shape (t,) [s]."""
        return np.arange(len(self.position)) / self.rate


GRID = 4e-3
"""Spacing of the grid of delays [s]; Gauss-Newton steps go on from its best one."""
BLOCKS = 25
"""Number of blocks in which scores are summed: in usual runs they last a second, longer than residuals are
correlated, and a standard deviation of 25 sums is known to 15 %."""
HALVED = 0.5
"""Ratio of residual variances below which the law has an additional term: feed-forward, damping and delay are
nearly alike, and a fit may trade them for a few percent of the residual."""
BELOW = 0.9
"""Share of the largest torque below which no sample is saturated."""
FREE = 1.0 / 3.0
"""Minimum share of samples to leave out those beside saturated ones too."""
SATURATED = 1.05
"""Torque by the linear law over the limit, above which a sample is saturated."""
MOSTLY = 0.5
"""Largest share of the torque's mean square that counts as noise."""
FEWEST = 20
"""Minimum number of saturated samples for a limit."""
LEVEL = 0.03
"""Maximum relative standard deviation of the torque of saturated samples."""
NOTHING = 1e-100
"""Norm below which a column is zero."""
TORQUE, VELOCITY, COMMAND_RATE, INTEGRAL, ONE = range(5)
"""Columns of the regression."""


@dataclass(frozen=True, eq=False)
class ServoFit:
    """The law of position servos, identified from runs."""

    law: ServoLaw  # the law, with infinite limits where no sample is saturated
    std: ServoLaw  # standard deviations of the numbers of the law; infinite for limits that are not reached
    period: float  # longest sampling period of the runs [s]
    residual: np.ndarray  # rms of the position error that the law does not explain, shape (n,) [rad]


def identify_servos(runs: Sequence[ServoRun]) -> ServoFit:
    """Identify the law of each joint's servo."""
    fits = [_Joint(runs, joint).fit() for joint in range(runs[0].position.shape[1])]
    law, std = (ServoLaw(*np.array([getattr(fit, name) for fit in fits]).T) for name in ("values", "stds"))
    period, residual = 1.0 / min(run.rate for run in runs), np.array([fit.residual for fit in fits])
    return ServoFit(law, std, period, residual)


class _Fit(NamedTuple):
    """Numbers of one joint in the order of `ServoLaw`, standard deviations, and the rms residual [rad]."""

    values: np.ndarray
    stds: np.ndarray
    residual: float


class _Solution(NamedTuple):
    """Columns that are used, delay, their coefficients, and the covariance of coefficients and delay."""

    terms: list[int]
    delay: float
    values: np.ndarray
    covariance: np.ndarray
    residual: float


@dataclass(frozen=True, eq=False)
class _Joint:
    """Fit of one joint's servo over all runs."""

    runs: Sequence[ServoRun]
    joint: int

    @cached_property
    def size(self) -> np.ndarray:
        """Magnitude of the torque before the low-pass, shape (t,) [N m]."""
        return np.concatenate([np.abs(run.raw_torque[run.inside, self.joint]) for run in self.runs])

    @cached_property
    def block(self) -> np.ndarray:
        """Index of the block of each sample, shape (t,)."""
        return np.arange(len(self.size)) * BLOCKS // len(self.size)

    def fit(self) -> _Fit:
        """Gains, limit and delay."""
        unsaturated = _away(self.size > BELOW * self.size.max())
        terms = [TORQUE, VELOCITY, ONE]
        solution = self._refine(self._search(terms, unsaturated), terms, unsaturated)
        limit, spread, used = self._limit(solution)
        solution = self._refine(solution.delay, terms, used)
        if np.isinf(limit):
            versions = [solution]
            for extra in ([COMMAND_RATE], [INTEGRAL], [COMMAND_RATE, INTEGRAL]):
                extended = [*terms, *extra]
                versions.append(self._refine(self._search(extended, used), extended, used))
            solution = min(versions, key=lambda version: version.residual**2 / HALVED ** len(version.terms))
        return _numbers(solution, limit, spread)

    def _system(self, delay: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All columns (t, k), position error (t,), and its derivative by the delay (t,)."""
        parts = [self._of_run(run, delay) for run in self.runs]
        return tuple(np.concatenate(part) for part in zip(*parts, strict=True))  # type: ignore[return-value]

    def _of_run(self, run: ServoRun, delay: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        joint, inside = self.joint, run.inside
        time = np.clip(run.time - delay, 0.0, run.time[-1])
        error = run.command(time)[:, joint] - run.position[:, joint]
        rate = run.command(time, 1)[:, joint]
        integral = np.cumsum(error) / run.rate
        columns = [run.torque[:, joint], run.velocity[:, joint], -rate, -integral, np.ones_like(error)]
        return np.stack(columns, axis=1)[inside], error[inside], rate[inside]

    def _search(self, terms: list[int], used: np.ndarray) -> float:
        """Delay of the smallest residual on a grid."""
        delays = np.arange(0.0, LONGEST, GRID)
        return float(min(delays.tolist(), key=lambda delay: self._squares(delay, terms, used)))

    def _squares(self, delay: float, terms: list[int], used: np.ndarray) -> float:
        """Sum of squared residuals of the position error, less the share of the torque's noise [rad^2]."""
        columns, error, _ = (part[used] for part in self._system(delay))
        columns, noise = columns[:, terms], self._noise(columns, terms, used)
        values = _least_squares(columns, error, noise)
        return float(np.sum((error - columns @ values) ** 2) - len(error) * noise @ values**2)

    def _refine(self, delay: float, terms: list[int], used: np.ndarray) -> _Solution:
        """Coefficients and delay; the delay may be slightly negative, as an estimate of zero is."""
        ends = (max(delay - 2.0 * GRID, -GRID), delay + 2.0 * GRID)
        best = minimize_scalar(self._squares, bounds=ends, args=(terms, used), options={"xatol": 1e-5})
        columns, error, rate = (part[used] for part in self._system(best.x))
        columns, noise = columns[:, terms], self._noise(columns, terms, used)
        values = _least_squares(columns, error, noise)
        residual = error - columns @ values
        scores = np.column_stack([columns, rate]) * residual[:, None]
        scores[:, : len(values)] += noise * values
        columns = np.column_stack([columns, rate])
        covariance = self._covariance(columns, scores, np.append(noise, 0.0), used)
        return _Solution(terms, float(best.x), values, covariance, float(np.sqrt(np.mean(residual**2))))

    def _noise(self, columns: np.ndarray, terms: list[int], used: np.ndarray) -> np.ndarray:
        """Variance of the noise of each term, of which only the torque has any, shape (k,)."""
        parts = [np.full(len(run.time[run.inside]), run.noise[self.joint] ** 2) for run in self.runs]
        variance = min(np.mean(np.concatenate(parts)[used]), MOSTLY * np.mean(columns[:, TORQUE] ** 2))
        return np.where(np.array(terms) == TORQUE, variance, 0.0)

    def _covariance(
        self, columns: np.ndarray, scores: np.ndarray, noise: np.ndarray, used: np.ndarray
    ) -> np.ndarray:
        scale = np.maximum(np.linalg.norm(columns, axis=0), NOTHING)
        columns, scores = columns / scale, scores / scale
        information = columns.T @ columns - np.diag(len(columns) * noise / scale**2)
        inverse, sums = np.linalg.pinv(information, hermitian=True), np.zeros((BLOCKS, columns.shape[1]))
        np.add.at(sums, self.block[used], scores)
        covariance = inverse @ (sums.T @ sums) @ inverse * BLOCKS / (BLOCKS - 1)
        return np.asarray(covariance / np.outer(scale, scale))

    def _limit(self, solution: _Solution) -> tuple[float, float, np.ndarray]:
        """Limit of the torque, its standard deviation, and the samples below it."""
        columns, error, _ = self._system(solution.delay)
        excess = (error - columns[:, solution.terms] @ solution.values) / solution.values[0]
        linear, size = np.abs(columns[:, TORQUE] + excess), self.size
        top = np.sort(size)[-FEWEST // 2]
        above = (linear > SATURATED * top) & (solution.values[0] > 0.0)
        if above.sum() < FEWEST or np.std(size[above]) > LEVEL * top:
            return np.inf, np.inf, np.ones(len(linear), bool)
        limit = float(np.median(size[above]))
        spread = np.sqrt(np.pi / 2.0) * float(np.std(size[above])) / np.sqrt(above.sum())  # of a median
        return limit, spread, _away(linear > 0.98 * limit)


def _away(marked: np.ndarray) -> np.ndarray:
    """Samples away from marked ones; samples beside them, or all, if few would remain."""
    for others in (~_near(marked), ~marked):
        if np.mean(others) > FREE:
            return np.asarray(others)
    return ~marked if np.sum(~marked) > FEWEST else np.ones(len(marked), bool)


def _near(marked: np.ndarray) -> np.ndarray:
    """Marked samples and those that the low-pass mixes with them: four are a period of its cut-off."""
    return np.convolve(marked, np.ones(9), "same") > 0.0


def _numbers(solution: _Solution, limit: float, spread: float) -> _Fit:
    """Gains from coefficients, with standard deviations to first order."""
    coefficients = np.zeros(ONE)
    used = [(place, term) for place, term in enumerate(solution.terms) if term < ONE]
    for place, term in used:
        coefficients[term] = solution.values[place]
    gains = np.array([1.0, *coefficients[1:]]) / coefficients[TORQUE]
    jacobian = np.zeros((5, len(solution.covariance)))
    jacobian[4, -1] = 1.0
    for place, term in used:
        jacobian[term, place] = (-gains[0] if term == TORQUE else 1.0) / coefficients[TORQUE]
        if term != TORQUE:
            jacobian[term, 0] = -gains[term] / coefficients[TORQUE]
    stds = np.sqrt(np.diag(jacobian @ solution.covariance @ jacobian.T))
    kp, kv, feed_forward, integral = gains
    return _Fit(
        np.array([kp, kv, limit, solution.delay, feed_forward, integral]),
        np.array([stds[0], stds[1], spread, stds[4], stds[2], stds[3]]),
        solution.residual,
    )


def _least_squares(columns: np.ndarray, values: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Coefficients of columns (t, k) whose own noise has some variances (k,)."""
    scale = np.maximum(np.linalg.norm(columns, axis=0), NOTHING)
    columns = columns / scale
    if not np.any(noise):
        return np.asarray(np.linalg.lstsq(columns, values, rcond=None)[0] / scale)
    information = columns.T @ columns - np.diag(len(columns) * noise / scale**2)
    return np.asarray(np.linalg.pinv(information, hermitian=True) @ (columns.T @ values) / scale)
