"""History: the likelihood of an arm's runs with some changes, and the evidence for a further change.

The unknowns of a run are those of the arm, plus effects of temperature, changes, and a random deviation. The
deviation scatters as the arm does, with heavy tails: each unknown of each run has its own variance, which is
usually that of the arm and occasionally many times as large (Student's distribution as a mixture of normal
distributions). Variances are estimated together with the changes. So an outlier is first explained by a large
variance, and a change is accepted only if it explains the runs better. The scatter of an arm is estimated in
the same way, from its own runs with that of its type as prior.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import linalg

from .evidence import (
    SHAPES,
    STEP,
    Evidence,
    Information,
    Questions,
    Sums,
    evidence_from,
    information,
)
from .learned import Learned
from .runs import ArmRuns
from .scatter import Scatter
from .suspects import EXCHANGE, Suspect, suspects

YEAR = 365.25
PLAUSIBLE = (0.2, 5.0)
"""Minimum and maximum friction at a temperature relative to the reference temperature [-]."""
ROUNDS = 12
"""Iterations between variances and unknowns, after which no score changes by one."""
KNOWN = 8
"""Number of runs from which the uncertainty of an arm's level is small against the scatter of a run."""


class Change(NamedTuple):
    """A change of a suspect, by its index: a step before run `start`, or a creep since the run before it."""

    suspect: int
    start: int
    shape: str


class Noise(NamedTuple):
    """Variances relative to the type: of the unit (r, m), and of each run relative to its unit (r, m)."""

    unit: np.ndarray
    run: np.ndarray

    def until(self, stop: int) -> "Noise":
        """The noise of the runs before `stop`; new runs have the variance of their unit."""
        added = max(stop - len(self.run), 0)
        new = np.ones((added, self.run.shape[1]))
        unit = np.concatenate([self.unit, np.repeat(self.unit[-1:], added, axis=0)])
        return Noise(unit[:stop], np.concatenate([self.run, new])[:stop])

    def usual_from(self, start: int) -> "Noise":
        """This noise with the variance of the unit for all runs from `start` on."""
        run = self.run.copy()
        run[start:] = 1.0
        return Noise(self.unit, run)


@dataclass(frozen=True, eq=False)
class State:
    """Explanation of the runs before `stop`.

    Attributes:
        changes: Changes that explain them.
        stop: Number of runs.
        score: Log-likelihood of the runs, up to a constant.
        noise: Variances.
        mean: The arm's unknowns minus `History.level`, then the amounts of the changes, shape (d + c,).
        lower: Cholesky factor of their precision.
        deviations: Squared deviation of each run over the variance of the arm, shape (r, m).
        seen: Share of each deviation that is determined by the run and not by the prior, shape (r, m).
    """

    changes: tuple[Change, ...]
    stop: int
    score: float
    noise: Noise
    mean: np.ndarray
    lower: np.ndarray
    deviations: np.ndarray
    seen: np.ndarray


@dataclass(frozen=True, eq=False)
class History:
    """Runs of one arm, with the scatter of its type."""

    learned: Learned
    runs: ArmRuns
    scatter: Scatter

    @cached_property
    def suspects(self) -> list[Suspect]:
        """Possible changes."""
        return suspects(self.learned)

    @cached_property
    def questions(self) -> Questions:
        """Suspects, prepared for the computation of evidence."""
        return Questions.of(self.suspects)

    @cached_property
    def level(self) -> np.ndarray:
        """Unknowns relative to which everything is expressed, to lose no digits, shape (d,)."""
        return self.learned.level(self.runs)[0]

    @cached_property
    def _equations(self) -> tuple[np.ndarray, np.ndarray]:
        normal = self.runs.normal / self.learned.trust
        at_level = np.einsum("rmn,rnd,d->rm", normal, self.runs.design, self.level)
        return normal, self.runs.right / self.learned.trust - at_level

    @cached_property
    def variance(self) -> np.ndarray:
        """Variance of each unknown from run to run on an arm of the type, shape (m,)."""
        return self.learned.run_variance(self.runs) * self.scatter.variance

    @cached_property
    def factor(self) -> np.ndarray:
        """Friction at a run's temperature over that at the reference, shape (r, m); one for all else.

        A worn bearing increases friction by the same percentage at every temperature.
        """
        frame = self.learned.frame
        factor, in_runs = np.ones((len(self.runs.days), len(frame.scale))), self.runs.design @ self.level
        for k in frame.thermal:
            place = frame.causes[k].place
            if abs(self.level[place]) > 1.0:  # exceeds the spread of units, so it is not near zero
                factor[:, place] = np.clip(in_runs[:, place] / self.level[place], *PLAUSIBLE)
        return factor

    def series(self, change: Change, stop: int) -> np.ndarray:
        """Share of a change in each run, shape (r,): 0 before it, 1 in the last run."""
        days = self.runs.days[:stop]
        if change.shape == STEP:
            return (np.arange(stop) >= change.start).astype(float)
        since = np.maximum(days - days[change.start - 1], 0.0)
        return since / max(float(since[-1]), 1e-3)

    def columns(self, change: Change, stop: int) -> np.ndarray:
        """Change of each run's unknowns per amount of a change, shape (r, m, k).

        An exchanged arm has other unknowns, including those of temperature.
        """
        suspect, series = self.suspects[change.suspect], self.series(change, stop)
        if suspect.name == EXCHANGE:
            return series[:, None, None] * self.runs.design[:stop]
        return (series[:, None] * self.factor[:stop])[:, :, None] * suspect.columns.T

    def std(self, change: Change) -> np.ndarray:
        """Prior standard deviation of the amounts of a change, shape (k,)."""
        suspect = self.suspects[change.suspect]
        return np.sqrt(2.0 * self.learned.units.variance) if suspect.name == EXCHANGE else suspect.std

    def quiet(self, stop: int) -> Noise:
        """Initial noise, with the variances of the type."""
        return Noise(*np.ones((2, stop, len(self.variance))))

    def explained(
        self,
        changes: Sequence[Change],
        stop: int,
        noise: Noise,
        rounds: int = ROUNDS,
        left_out: int | None = None,
    ) -> State:
        """Unknowns, amounts and variances of the runs before `stop`, starting from some noise.

        One run can be left out.
        """
        noise, state = noise.until(stop), None
        for _ in range(rounds):
            state = self._round(tuple(changes), stop, noise, left_out)
            noise = self._variances(state, noise)
        assert state is not None  # at least one round
        return replace(state, noise=noise)

    def _round(self, changes: tuple[Change, ...], stop: int, noise: Noise, left_out: int | None) -> State:
        normal, right = self._until(stop, left_out)
        variance = self.variance * noise.unit * noise.run
        info, columns = information(normal, right, variance), self._columns(changes, stop)
        mean, lower, score = self._posterior(changes, info, columns)
        score += float(np.sum(info.constant)) + self._noise_score(noise, self._units(changes, stop))
        root = np.sqrt(variance)
        residual = right - np.einsum("rmn,rn->rm", normal, columns @ mean)
        amounts = root * np.einsum("rmn,rn->rm", info.inverse, root * residual)
        uncertainty = variance * np.diagonal(info.inverse, axis1=1, axis2=2)
        seen = 1.0 - uncertainty / variance
        if stop < KNOWN:
            uncertainty = uncertainty + self._level_uncertainty(info, columns, root, lower)
        deviations = (amounts**2 + uncertainty) / (self.variance * noise.unit)
        return State(changes, stop, score, noise, mean, lower, deviations, seen)

    def _until(self, stop: int, left_out: int | None) -> tuple[np.ndarray, np.ndarray]:
        normal, right = (array[:stop] for array in self._equations)
        if left_out is None:
            return normal, right
        others = np.arange(stop) != left_out
        return normal * others[:, None, None], right * others[:, None]

    def _level_uncertainty(
        self, info: Information, columns: np.ndarray, root: np.ndarray, lower: np.ndarray
    ) -> np.ndarray:
        """Variance of deviations by the uncertainty of the arm's unknowns, shape (r, m)."""
        seen = root[:, :, None] * (np.eye(root.shape[1]) - info.inverse) / root[:, None, :]
        flat = (seen @ columns).reshape(-1, columns.shape[2])
        solved = linalg.solve_triangular(lower, flat.T, lower=True, check_finite=False)
        return np.sum(solved**2, axis=0).reshape(root.shape)

    def _units(self, changes: Sequence[Change], stop: int) -> list[slice]:
        """Runs of each physical unit under the arm's name."""
        edges = sorted({change.start for change in changes if self.suspects[change.suspect].name == EXCHANGE})
        return [slice(*bounds) for bounds in zip([0, *edges], [*edges, stop], strict=True)]

    def _variances(self, state: State, noise: Noise) -> Noise:
        """The most probable variances, by each run's deviations over the unit's variance."""
        tails, alike = self.scatter.tails, self.scatter.alike
        run = (tails + state.deviations) / (tails + 1.0)
        unit = noise.unit.copy()
        for rows in self._units(state.changes, state.stop):
            total = np.sum(noise.unit[rows] * state.deviations[rows] / run[rows], axis=0)
            unit[rows] = (alike + total) / (alike + len(run[rows]))
        return Noise(unit, run)

    def _noise_score(self, noise: Noise, units: Sequence[slice]) -> float:
        """Logarithm of the prior density of log-variances, which gives Student's distribution."""
        first = noise.unit[[rows.start for rows in units]]
        return 0.5 * (self.scatter.tails * _log_prior(noise.run) + _log_prior(first, self.scatter.alike))

    def _columns(self, changes: Sequence[Change], stop: int) -> np.ndarray:
        return np.concatenate(
            [self.runs.design[:stop], *(self.columns(change, stop) for change in changes)], axis=2
        )

    def _prior(self, changes: Sequence[Change]) -> tuple[np.ndarray, np.ndarray]:
        """Prior mean and precision of unknowns and amounts, each (d + c,)."""
        units = self.learned.units
        precisions = [self.std(change) ** -2.0 for change in changes]
        amounts = np.zeros(sum(len(precision) for precision in precisions))
        return (
            np.concatenate([units.mean - self.level, amounts]),
            np.concatenate([1.0 / units.variance, *precisions]),
        )

    def _posterior(
        self, changes: Sequence[Change], info: Information, columns: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """Posterior mean, Cholesky factor of the precision, and log-likelihood up to constants."""
        before, weight = self._prior(changes)
        weighted = info.normal @ columns
        flat = columns.reshape(-1, columns.shape[2])
        precision = flat.T @ weighted.reshape(flat.shape) + np.diag(weight)
        right = flat.T @ info.right.reshape(-1) + weight * before
        lower = linalg.cholesky(precision, lower=True, check_finite=False)
        half = linalg.solve_triangular(lower, right, lower=True, check_finite=False)
        mean = linalg.solve_triangular(lower, half, lower=True, trans=1, check_finite=False)
        score = 0.5 * (half @ half - before @ (weight * before) + np.sum(np.log(weight)))
        return mean, lower, float(score - np.sum(np.log(np.diag(lower))))

    def evidence(
        self, state: State, starts: Sequence[int], noises: Sequence[Noise | None]
    ) -> list[list[Evidence]]:
        """Evidence for a further step or creep from each of some runs on, one list for each noise.

        Args:
            state: Current explanation of the runs.
            starts: First runs after a change.
            noises: Variances to assume from the change on; None for those of the state, with which a change
                gains little, because the runs after it are already explained as outliers.
        """
        current, prior = self._sums(state, state.noise), self._prior(state.changes)
        lists = []
        for noise in noises:
            after, evidence = current if noise is None else self._sums(state, noise), list[Evidence]()
            for start in starts:
                series = {shape: self.series(Change(0, start, shape), state.stop) for shape in SHAPES}
                evidence += evidence_from(start, series, current, after, *prior)
            lists.append(evidence)
        return lists

    def _sums(self, state: State, noise: Noise) -> Sums:
        info = information(*self._until(state.stop, None), self.variance * noise.unit * noise.run)
        return Sums.of(info, self._columns(state.changes, state.stop), self.factor[: state.stop])

    def evidence_in_run(self, state: State, run: int) -> Evidence:
        """Evidence for a change in a single run, which then has the variance of its unit."""
        variances = state.noise.run.copy()
        variances[run] = 1.0
        before, weight = self._prior(state.changes)
        sums = self._sums(state, Noise(state.noise.unit, variances))
        lower = linalg.cholesky(sums.normal.sum(axis=0) + np.diag(weight), lower=True, check_finite=False)
        half = linalg.solve_triangular(lower, sums.right.sum(axis=0) + weight * before, lower=True)
        projected = linalg.solve_triangular(lower, sums.across[run], lower=True, check_finite=False)
        precision = sums.change_normal[run] - projected.T @ projected
        return Evidence(run, STEP, precision, sums.change_right[run] - projected.T @ half)

    def squared_deviations(self, run: int, level: np.ndarray) -> np.ndarray:
        """Squared deviations of a run from an arm's unknowns, over the variance of the type, shape (m,)."""
        normal, right = (array[run] for array in self._equations)
        residual = right - normal @ (self.runs.design[run] @ (level - self.level))
        solution = np.linalg.solve(normal + np.diag(1.0 / self.variance), residual)
        return np.asarray(solution**2 / self.variance)


def _log_prior(variances: np.ndarray, freedom: np.ndarray | float = 1.0) -> float:
    return float(np.sum(freedom * (1.0 - np.log(variances) - 1.0 / variances)))
