r"""Identification of the law of position servos from commands, positions and torque.

The law of a joint, solved for the position error, is linear in its coefficients for a delay d,

.. math:: c(t - d) - q = \alpha \tau + \beta \dot q - \varphi \dot c(t - d) - \iota \int (c(t - d) - q)\, dt
    + \gamma, \quad k_p = 1 / \alpha, \; k_v = \beta / \alpha, \ldots

Its noise is that of the encoder. In the form solved for the torque, a stiff servo would multiply that noise by
its gain, and the fit would prefer small gains. The delay is found on a grid and refined by Gauss-Newton steps.
All signals pass the same low-pass, which leaves a linear law as it is; samples at the limit of the torque are
left out. Standard deviations allow for correlated residuals, since scores are summed over blocks.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.stats import chi2

from ..arm.derivatives import differentiate
from ..arm.servo_law import ServoLaw
from ..preparation.cutoffs import position_cutoff
from ..preparation.even import Even
from ..preparation.filters import low_pass
from ..recordings.recording import Recording

LONGEST = 0.15
"""Longest delay that is considered [s]: five cycles of a 30 Hz bus."""
GRID = 4e-3
"""Spacing of the grid of delays [s]; Gauss-Newton steps go on from its best one."""
BLOCKS = 25
"""Number of blocks in which scores are summed: in usual runs they last a second, longer than residuals are
correlated, and a standard deviation of 25 sums is known to 15 %."""
SURE = 0.999
"""Probability with which an additional term differs from zero before the law has it."""
BELOW = 0.9
"""Share of the largest torque below which no sample is saturated."""
SATURATED = 1.05
"""Torque by the linear law over the limit, above which a sample is saturated."""
FEWEST = 20
"""Minimum number of saturated samples for a limit."""
LEVEL = 0.03
"""Maximum relative standard deviation of the torque of saturated samples."""
ERROR, FEED_FORWARD, INTEGRAL = 0, 2, 3


@dataclass(frozen=True, eq=False)
class ServoFit:
    """The law of position servos, identified from runs.

    Attributes:
        law: The law, with infinite limits where no sample is saturated.
        std: Standard deviations of the numbers of the law; infinite if not determined.
        explained: Share of the variance of the position error that the law explains, shape (n,) [-].
    """

    law: ServoLaw
    std: ServoLaw
    explained: np.ndarray


@dataclass(frozen=True, eq=False)
class ServoRun:
    """Low-passed signals of one run on an even time axis; n joints.

    Attributes:
        rate: Sampling rate [Hz].
        cutoff: Cut-off of the low-pass [Hz].
        position: Positions, shape (t, n) [rad].
        velocity: Velocities, shape (t, n) [rad/s].
        torque: Torques, shape (t, n) [N m].
        raw_torque: Torques before the low-pass, shape (t, n) [N m].
        command: Commands as functions of the time since the first sample.
    """

    rate: float
    cutoff: float
    position: np.ndarray
    velocity: np.ndarray
    torque: np.ndarray
    raw_torque: np.ndarray
    command: CubicSpline

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
        return cls(
            even.rate, cutoff, position, differentiate(position, even.rate)[0], scale * torque,
            scale * even.signal(even.measures), CubicSpline(even.time - even.time[0], command),
        )  # fmt: skip

    @property
    def inside(self) -> slice:
        """Samples away from the transients of the filters, thinned to the band of the low-pass."""
        edge = int(self.rate * (LONGEST + 2.0 / self.cutoff))
        return slice(edge, len(self.position) - edge, max(1, int(self.rate / (4.0 * self.cutoff))))

    @property
    def time(self) -> np.ndarray:
        """Time since the first sample, shape (t,) [s]."""
        return np.arange(len(self.position)) / self.rate


def identify_servos(runs: Sequence[ServoRun]) -> ServoFit:
    """Identify the law of each joint's servo."""
    fits = [JointServo(runs, joint).fit() for joint in range(runs[0].position.shape[1])]
    law, std = (ServoLaw(*np.array([getattr(fit, name) for fit in fits]).T) for name in ("values", "stds"))
    return ServoFit(law, std, np.array([fit.explained for fit in fits]))


class _Fit(NamedTuple):
    """Numbers of one joint in the order of `ServoLaw`, their standard deviations, and the explained share."""

    values: np.ndarray
    stds: np.ndarray
    explained: float


class _Solution(NamedTuple):
    """Delay, coefficients, and the covariance of coefficients and delay."""

    delay: float
    values: np.ndarray
    covariance: np.ndarray


@dataclass
class JointServo:
    """Fit of one joint's servo over all runs."""

    runs: Sequence[ServoRun]
    joint: int
    torque: np.ndarray = field(init=False)
    size: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.torque = self._joined("torque")
        self.size = np.abs(self._joined("raw_torque"))
        self.block = np.arange(len(self.torque)) * BLOCKS // len(self.torque)

    def _joined(self, name: str) -> np.ndarray:
        return np.concatenate([getattr(run, name)[run.inside, self.joint] for run in self.runs])

    def fit(self) -> _Fit:
        """Gains, limit and delay."""
        unsaturated = self.size <= BELOW * self.size.max()
        delay = self._delay_on_grid(unsaturated)
        terms = [0, 1, 4]
        solution = self._refine(delay, terms, unsaturated)
        limit, spread, used = self._limit(solution, terms)
        solution = self._refine(solution.delay, terms, used)
        for extra in (FEED_FORWARD, INTEGRAL):
            more = self._refine(solution.delay, [*terms, extra], used)
            if more.values[-1] ** 2 > chi2.ppf(SURE, 1) * more.covariance[-2, -2]:
                terms, solution = [*terms, extra], more
        return self._result(solution, terms, limit, spread, used)

    def _system(self, delay: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Columns (t, 5), position error (t,), and its derivative by the delay (t,)."""
        parts = [self._of_run(run, delay) for run in self.runs]
        return tuple(np.concatenate(part) for part in zip(*parts, strict=True))  # type: ignore[return-value]

    def _of_run(self, run: ServoRun, delay: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        joint, inside = self.joint, run.inside
        time = np.clip(run.time - delay, 0.0, run.time[-1])
        error = run.command(time)[:, joint] - run.position[:, joint]
        rate = run.command(time, 1)[:, joint]
        integral = np.cumsum(error - error.mean()) / run.rate
        columns = [run.torque[:, joint], run.velocity[:, joint], -rate, -integral, np.ones_like(error)]
        return np.stack(columns, axis=1)[inside], error[inside], rate[inside]

    def _delay_on_grid(self, used: np.ndarray) -> float:
        delays, squares = np.arange(0.0, LONGEST, GRID), []
        for delay in delays:
            columns, error, _ = self._system(float(delay))
            columns = columns[used][:, [0, 1, 4]]
            squares.append(np.sum((error[used] - columns @ _solve(columns, error[used])) ** 2))
        return float(delays[np.argmin(squares)])

    def _refine(self, delay: float, terms: list[int], used: np.ndarray) -> _Solution:
        for _ in range(10):
            columns, error, rate = (part[used] for part in self._system(delay))
            columns = columns[:, terms]
            values = _solve(columns, error)
            whole, residual = np.column_stack([columns, rate]), error - columns @ values
            step = float(np.clip(_solve(whole, residual)[-1], -GRID, GRID))
            before, delay = delay, float(np.clip(delay + step, 0.0, LONGEST))
            if abs(delay - before) < 1e-7:
                break
        return _Solution(delay, values, self._covariance(whole, residual, used))

    def _covariance(self, columns: np.ndarray, residual: np.ndarray, used: np.ndarray) -> np.ndarray:
        scale = np.linalg.norm(columns, axis=0)
        columns = columns / scale
        inverse = np.linalg.pinv(columns.T @ columns, hermitian=True)
        scores = np.zeros((BLOCKS, columns.shape[1]))
        np.add.at(scores, self.block[used], columns * residual[:, None])
        covariance = inverse @ (scores.T @ scores) @ inverse * BLOCKS / (BLOCKS - 1)
        return np.asarray(covariance / np.outer(scale, scale))

    def _limit(self, solution: _Solution, terms: list[int]) -> tuple[float, float, np.ndarray]:
        """Limit of the torque, its standard deviation, and the samples below it."""
        columns, error, _ = self._system(solution.delay)
        linear = np.abs(self.torque + (error - columns[:, terms] @ solution.values) / solution.values[0])
        top = np.sort(self.size)[-FEWEST // 2]
        above = (linear > SATURATED * top) & (solution.values[0] > 0.0)
        if above.sum() < FEWEST or np.std(self.size[above]) > LEVEL * top:
            return np.inf, np.inf, np.ones(len(linear), bool)
        limit = float(np.median(self.size[above]))
        near = np.convolve(linear > 0.98 * limit, np.ones(9), "same") > 0
        return limit, 1.25 * float(np.std(self.size[above])) / np.sqrt(above.sum()), ~near

    def _result(
        self, solution: _Solution, terms: list[int], limit: float, spread: float, used: np.ndarray
    ) -> _Fit:
        columns, error, _ = self._system(solution.delay)
        residual = (error - columns[:, terms] @ solution.values)[used]
        explained = 1.0 - float(np.var(residual) / np.var(error[used]))
        full = np.zeros(5)
        full[terms] = solution.values
        alpha = full[0]
        gains = np.array([1.0, *full[1:4]]) / alpha
        jacobian = np.zeros((5, len(terms) + 1))
        jacobian[4, -1] = 1.0
        for place, term in enumerate(terms):
            if term < 4:
                jacobian[term, place] = 1.0 / alpha if term else 0.0
        jacobian[:4, 0] = -gains / alpha
        for place, term in enumerate(terms):
            if 0 < term < 4:
                jacobian[term, place] = 1.0 / alpha
        stds = np.sqrt(np.diag(jacobian @ solution.covariance @ jacobian.T))
        return _Fit(
            np.array([gains[0], gains[1], limit, solution.delay, gains[2], gains[3]]),
            np.array([stds[0], stds[1], spread, stds[4], stds[2], stds[3]]),
            explained,
        )


def _solve(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
    scale = np.linalg.norm(columns, axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    return np.asarray(np.linalg.lstsq(columns / scale, values, rcond=None)[0] / scale)
