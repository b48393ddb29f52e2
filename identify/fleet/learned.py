"""Statistics of a type of arm: typical values, spread between units, scatter between runs, and residuals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from ..errors import RecordingError
from ..fit.estimators.compressed import Compressed
from .runs import ArmRuns, Frame, Population, Run, design_of, population, scattered

PASSES = 3
"""Iterations of scatter, units and linearization point: the third changes none of them by a tenth."""
LEAST_SCATTER = 1e-3
"""Minimum scatter from run to run, relative to the spread between units [-]."""
FIRST_SCATTER = 0.1
"""Initial scatter from run to run, relative to the spread between units [-]."""
MOST = 1.0
"""Maximum logarithm of a drive gain over the nominal one: data sheets are not wrong by a factor of e."""
ALIKE = 10
"""Weight of the scatter of other joints, in pairs of runs: a few pairs may show no scatter by chance."""
HALVINGS = 20
"""Number of bisections of the logarithm of a scatter, after which it is known to well below a percent."""
ROBUST = 1.4826
"""Ratio of the standard deviation to the median absolute value for normal numbers."""


@dataclass(frozen=True, eq=False)
class Learned:
    """Statistics of a type of arm, from all its runs.

    Attributes:
        frame: Causes and units.
        arms: Runs of each arm, linearized about the values of that arm.
        units: Mean and spread of the unknowns between units, including those of temperature, shape (d,).
        trust: Variance between runs of one arm, relative to what their residuals suggest, at most one. Model
            errors repeat in each run of one motion, so they are not scatter [-].
        scatter: Variance of each scattering cause from run to run, over `Frame.sizes` squared, shape (s,).
        freedom: Number of pairs of runs from which the scatter was estimated.
    """

    frame: Frame
    arms: Mapping[str, ArmRuns]
    units: Population
    trust: float
    scatter: np.ndarray
    freedom: int

    @property
    def scattering(self) -> list[int]:
        """Indices of the causes that scatter."""
        return [index for index, cause in enumerate(self.frame.causes) if cause.scatters]

    def sizes(self, runs: ArmRuns) -> np.ndarray:
        """`Frame.sizes` of an arm's scattering causes, shape (s,)."""
        return self.frame.sizes(runs.about)[self.scattering]

    def run_variance(self, runs: ArmRuns) -> np.ndarray:
        """Variance of each unknown of an arm from run to run, in the frame's units, shape (m,)."""
        frame = self.frame
        variances = (LEAST_SCATTER**2) * self.units.variance[: len(frame.scale)]
        for k, variance, size in zip(self.scattering, self.scatter, self.sizes(runs), strict=True):
            place = frame.unknown_of(frame.causes[k])
            if place >= 0:
                of_cause = variance * (size * frame.directions[k, place]) ** 2
                variances[place] = max(variances[place], of_cause)
        return variances

    @property
    def spread(self) -> np.ndarray:
        """Standard deviation of each scattering cause's amount between units, shape (s,)."""
        directions = self.frame.directions[self.scattering]
        return 1.0 / np.sqrt(np.sum(directions**2 / self.units.variance[: directions.shape[1]], axis=1))

    def information(self, runs: ArmRuns) -> tuple[np.ndarray, np.ndarray]:
        """Normal equations of runs for the arm's unknowns, including their scatter, (r, m, m) and (r, m)."""
        directions, variance = self.frame.directions[self.scattering], self.scatter * self.sizes(runs) ** 2
        return scattered(runs.normal / self.trust, runs.right / self.trust, directions, variance)

    def level(self, runs: ArmRuns) -> tuple[np.ndarray, np.ndarray]:
        """Mean and covariance of the arm's unknowns, by these runs."""
        return self.units.posterior(*summed(runs, *self.information(runs)))

    def deviations(self, runs: ArmRuns, level: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Amount of each scattering cause in each run relative to the arm's level (d,), and its covariance.

        The prior is the spread between units, and the covariance is that of the noise. Shapes are (r, s) and
        (r, s, s).
        """
        directions = self.frame.directions[self.scattering]
        residual = runs.right - np.einsum("rmn,rnd,d->rm", runs.normal, runs.design, level)
        precision = directions @ runs.normal @ directions.T / self.trust
        covariance = np.linalg.inv(precision + np.diag(self.spread**-2.0))
        amounts = np.einsum("rst,rt->rs", covariance, residual @ directions.T) / self.trust
        return amounts, covariance @ precision @ covariance


def learned(frame: Frame, arms: Mapping[str, Sequence[Run]]) -> Learned:
    """Typical values, spread and scatter of the arms of one type."""
    joints = frame.kind.model.robot.dof
    values, gain = frame.before.mean[:-joints], frame.kind.gain
    runs = {name: ArmRuns.of(frame, of_arm, values, gain) for name, of_arm in arms.items()}
    scatters = sum(cause.scatters for cause in frame.causes)
    statistics = Learned(frame, runs, frame.start, 1.0, np.ones(scatters), 0)
    sizes = frame.sizes(frame.before.mean / frame.scale)[statistics.scattering]
    statistics = replace(statistics, scatter=(FIRST_SCATTER * statistics.spread / sizes) ** 2)
    for _ in range(PASSES):
        sums = [summed(of_arm, *statistics.information(of_arm)) for of_arm in statistics.arms.values()]
        normals, rights = (np.stack(part) for part in zip(*sums, strict=True))
        units = population(normals, rights, frame.start)
        statistics = _scatter(replace(statistics, units=units))
        relinearized = {name: _relinearized(statistics, of_arm) for name, of_arm in statistics.arms.items()}
        statistics = replace(statistics, arms=relinearized)
    return statistics


def summed(runs: ArmRuns, normal: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normal equations of all runs together for the arm's unknowns, (d, d) and (d,)."""
    transposed = np.swapaxes(runs.design, 1, 2)
    return np.sum(transposed @ (normal @ runs.design), axis=0), np.einsum("rdm,rm->d", transposed, right)


def _relinearized(statistics: Learned, runs: ArmRuns) -> ArmRuns:
    """The runs, linearized about the values that they suggest."""
    frame, joints = statistics.frame, statistics.frame.kind.model.robot.dof
    values = statistics.level(runs)[0][: len(frame.scale)] * frame.scale
    gain = frame.kind.gain * np.exp(np.clip(values[-joints:], -MOST, MOST))
    return ArmRuns.of(frame, runs.runs, values[:-joints], gain)


def _scatter(statistics: Learned) -> Learned:
    """The statistics with scatter, by medians of differences of successive runs, robust against changes."""
    statistics = replace(statistics, trust=1.0)
    differences, expected = [], []
    for runs in statistics.arms.values():
        if np.count_nonzero(~runs.loose) < 2:
            continue
        amounts, covariance = statistics.deviations(runs[~runs.loose], statistics.level(runs)[0])
        sizes = statistics.sizes(runs)
        noise = np.diagonal(covariance, axis1=1, axis2=2) / sizes**2
        differences.append(np.diff(amounts / sizes, axis=0))
        expected.append(noise[1:] + noise[:-1])
    if not differences:
        return statistics
    pairs, variances = np.concatenate(differences), np.concatenate(expected)
    # Rounding makes variances negative if the numbers of a run are damaged; such a run is left out.
    sound = np.all(variances > 0.0, axis=1)
    if not sound.any():
        return statistics
    pairs, variances = pairs[sound], variances[sound]
    ratios = _robust(pairs / np.sqrt(variances))
    trust = float(np.clip(np.median(ratios), LEAST_SCATTER, 1.0))
    mean = statistics.units.mean[: len(statistics.frame.scale)]
    sizes = statistics.frame.sizes(mean)[statistics.scattering]
    least = (LEAST_SCATTER * statistics.spread / sizes) ** 2
    share = _excess(pairs, trust * variances, least) / least
    scatter = least * _averaged(statistics, share, len(pairs))
    return replace(statistics, trust=trust, scatter=scatter, freedom=len(pairs))


def _averaged(statistics: Learned, share: np.ndarray, pairs: int) -> np.ndarray:
    """Relative scatter (s,), averaged with that of the same effect on other joints."""
    effects = np.array([statistics.frame.causes[index].effect for index in statistics.scattering])
    typical = np.array([np.median(share[effects == effect]) for effect in effects])
    return (pairs * share + ALIKE * typical) / (pairs + ALIKE)


def _robust(values: np.ndarray) -> np.ndarray:
    """Variance of each column, by the median of absolute values."""
    return np.square(ROBUST * np.median(np.abs(values), axis=0))


def _excess(differences: np.ndarray, expected: np.ndarray, least: np.ndarray) -> np.ndarray:
    """Variance of a run in excess of the expected variance of the difference of a pair, shape (s,)."""
    low, high = least, np.maximum(_robust(differences), 2.0 * least)
    for _ in range(HALVINGS):
        middle = np.sqrt(low * high)
        more = _robust(differences / np.sqrt(expected + 2.0 * middle)) > 1.0
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return low


FEWEST = 3
"""Minimum number of runs for the usual residual: two show only its order of magnitude."""
SECONDS_A_YEAR = 365.25 * 86400.0


@dataclass(frozen=True, eq=False)
class Expected:
    """Expected behavior of an arm, by its runs.

    Attributes:
        runs: Runs without an unknown payload.
        level: The arm's unknowns, shape (d,).
        mean: Mean log-residual of a run with the values of the other runs, shape (n,).
        scatter: Standard deviation of the log-residual from run to run, shape (n,) [-].
        freedom: Number of pairs of runs, of all arms of the type, from which the scatter is estimated.
    """

    runs: ArmRuns
    level: np.ndarray
    mean: np.ndarray
    scatter: np.ndarray
    freedom: int

    @classmethod
    def of(cls, learned: Learned, runs: ArmRuns) -> "Expected":
        """Expected behavior by an arm's runs, and by residuals of successive runs of all arms of the type.

        Raises:
            RecordingError: If there are fewer than `FEWEST` runs.
        """
        usable = runs[~runs.loose]
        if len(usable.runs) < FEWEST:
            raise RecordingError(
                f"only {len(usable.runs)} runs without an unknown payload since the last change: the usual "
                f"residual needs {FEWEST}; record more runs"
            )
        mean = np.mean(_log_residuals(learned, usable), axis=0)
        logarithms = [_log_residuals(learned, arm[~arm.loose]) for arm in learned.arms.values()]
        pairs = np.concatenate([np.diff(of_arm, axis=0) for of_arm in logarithms])
        scatter = np.sqrt(0.5 * np.mean(pairs**2, axis=0))
        return cls(usable, learned.level(usable)[0], mean, scatter, len(pairs))

    @property
    def seconds(self) -> float:
        """Median duration of the runs [s]; residuals are comparable over this duration."""
        return float(np.median([run.summary.seconds for run in self.runs.runs]))

    def residual(self, run: Run) -> np.ndarray:
        """RMS residual of a run with this arm's values, shape (n,) [N m]."""
        design = design_of(self.runs.frame, [*self.runs.runs, run])[-1]
        return _residual(self.runs.frame, run, design @ self.level)

    def limit(self, alarms_per_year: float) -> np.ndarray:
        """Residual that a sound arm in continuous motion exceeds at this rate, over all joints, (n,) [N m].

        Scatter of friction adds to the squared residual, so its logarithm has a longer upper tail than a
        normal distribution. It is modeled as Laplace's, or as Student's if few pairs make that longer.
        """
        count, joints = len(self.runs.runs), len(self.mean)
        share = min(alarms_per_year * self.seconds / (SECONDS_A_YEAR * joints), 1.0)
        deviations = float(
            max(stats.t.isf(share, self.freedom), stats.laplace.isf(share, scale=np.sqrt(0.5)))
        )
        deviations *= float(np.sqrt(1.0 + 1.0 / count))
        return np.exp(self.mean + deviations * self.scatter)


def _log_residuals(learned: Learned, runs: ArmRuns) -> np.ndarray:
    """Logarithm of the residual of each run with the values of the arm's other runs, shape (r, n)."""
    normal, right = learned.information(runs)
    transposed, units = np.swapaxes(runs.design, 1, 2), learned.units
    normals, rights = transposed @ (normal @ runs.design), np.einsum("rdm,rm->rd", transposed, right)
    precision = normals.sum(axis=0) - normals + np.diag(1.0 / units.variance)
    sides = rights.sum(axis=0) - rights + units.mean / units.variance
    levels = np.linalg.solve(precision, sides[:, :, None])[:, :, 0]
    triples = zip(runs.runs, runs.design, levels, strict=True)
    residuals = [_residual(runs.frame, run, design @ level) for run, design, level in triples]
    return np.log(residuals).reshape(len(residuals), runs.frame.kind.model.robot.dof)


def _residual(frame: Frame, run: Run, unknowns: np.ndarray) -> np.ndarray:
    """RMS residual of a run with unknowns in the frame's units, shape (n,) [N m]."""
    joints, values = frame.kind.model.robot.dof, unknowns * frame.scale
    compressed = Compressed(tuple(run.summary.factors), run.summary.counts)
    return compressed.residual_std(values[:-joints], frame.kind.gain * np.exp(values[-joints:]))
