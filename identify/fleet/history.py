"""History: how probable an arm's runs are with given changes, and what a further change would explain.

A run's unknowns are the arm's, with temperature, changes, and a deviation of its own. That deviation is as
large as the arm's own scatter, and has heavy tails: each unknown of each run has a variance of its own, which
is usually that of the arm and now and then many times as large (Student's distribution as a mixture of normal
ones). Variances are found with the changes, so that a run far out of line explains itself, and a change is
believed only if that is the worse explanation. The arm's scatter is found the same way, from its own runs
and about that of its type.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import linalg

from .evidence import SHAPES, STEP, Evidence, Questions, evidence_from
from .learned import Learned
from .runs import ArmRuns
from .says import Says, Sums, says
from .scatter import Scatter
from .suspects import EXCHANGE, Suspect, suspects

YEAR = 365.25
PLAUSIBLE = (0.2, 5.0)
"""Friction at a temperature over that at the reference, at least and at most [-]."""
ROUNDS = 12
"""Of variances and unknowns, each from the other; what is left changes no score by one."""
KNOWN = 8
"""Runs from which on what is open of an arm's level is little beside a run's own scatter."""


class Change(NamedTuple):
    """A suspect, by its place, that changes at once before run `start`, or creeps since the run before it."""

    suspect: int
    start: int
    shape: str


class Noise(NamedTuple):
    """Variances over those of the type: of the unit (r, m), and of each run (r, m) beyond its unit's."""

    unit: np.ndarray
    run: np.ndarray

    def until(self, stop: int) -> "Noise":
        """For so many runs; those that are new are usual."""
        more = max(stop - len(self.run), 0)
        new = np.ones((more, self.run.shape[1]))
        unit = np.concatenate([self.unit, np.repeat(self.unit[-1:], more, axis=0)])
        return Noise(unit[:stop], np.concatenate([self.run, new])[:stop])

    def usual_from(self, start: int) -> "Noise":
        """The same with usual runs from one on."""
        run = self.run.copy()
        run[start:] = 1.0
        return Noise(self.unit, run)


@dataclass(frozen=True, eq=False)
class State:
    """Runs before `stop` explained.

    Attributes:
        changes: By these.
        stop: Number of runs.
        score: Logarithm of their probability, but for a constant.
        noise: Variances.
        mean: The arm's unknowns about `History.level`, then the amounts of the changes, shape (d + c,).
        lower: Root of their precision.
        deviations: Squares of each run's own deviations over the variance of the arm, shape (r, m).
        seen: Share of each deviation that the run shows, the rest being what is usual, shape (r, m).
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
    """One arm's runs, and how those of its type scatter."""

    learned: Learned
    runs: ArmRuns
    scatter: Scatter

    @cached_property
    def suspects(self) -> list[Suspect]:
        """What may have happened."""
        return suspects(self.learned)

    @cached_property
    def questions(self) -> Questions:
        """The same as evidence is asked about them."""
        return Questions.of(self.suspects)

    @cached_property
    def level(self) -> np.ndarray:
        """Unknowns about which all is expressed, so that no digits are lost, shape (d,)."""
        return self.learned.level(self.runs)[0]

    @cached_property
    def _given(self) -> tuple[np.ndarray, np.ndarray]:
        normal = self.runs.normal / self.learned.trust
        about = np.einsum("rmn,rnd,d->rm", normal, self.runs.design, self.level)
        return normal, self.runs.right / self.learned.trust - about

    @cached_property
    def usual(self) -> np.ndarray:
        """Variance of each unknown from run to run on an arm of the type, shape (m,)."""
        return self.learned.run_variance(self.runs) * self.scatter.variance

    @cached_property
    def factor(self) -> np.ndarray:
        """Friction at a run's temperature over that at the reference, shape (r, m); one for all else.

        A worn bearing has so much more friction, in per cent, warm or cold.
        """
        frame = self.learned.frame
        found, in_runs = np.ones((len(self.runs.days), len(frame.scale))), self.runs.design @ self.level
        for k in frame.thermal:
            place = frame.causes[k].place
            if abs(self.level[place]) > 1.0:  # more than units differ by: not near zero
                found[:, place] = np.clip(in_runs[:, place] / self.level[place], *PLAUSIBLE)
        return found

    def series(self, change: Change, stop: int) -> np.ndarray:
        """How much of a change each run has, shape (r,): none at first, all by now."""
        days = self.runs.days[:stop]
        if change.shape == STEP:
            return (np.arange(stop) >= change.start).astype(float)
        since = np.maximum(days - days[change.start - 1], 0.0)
        return since / max(float(since[-1]), 1e-3)

    def columns(self, change: Change, stop: int) -> np.ndarray:
        """What amounts of a change add to the unknowns of each run, shape (r, m, k).

        Another arm has unknowns of its own, those of temperature too.
        """
        suspect, series = self.suspects[change.suspect], self.series(change, stop)
        if suspect.name == EXCHANGE:
            return series[:, None, None] * self.runs.design[:stop]
        return (series[:, None] * self.factor[:stop])[:, :, None] * suspect.columns.T

    def std(self, change: Change) -> np.ndarray:
        """Usual size of its amounts, shape (k,)."""
        suspect = self.suspects[change.suspect]
        return np.sqrt(2.0 * self.learned.units.variance) if suspect.name == EXCHANGE else suspect.std

    def quiet(self, stop: int) -> Noise:
        """Variances before anything is known."""
        return Noise(*np.ones((2, stop, len(self.usual))))

    def explained(
        self, changes: Sequence[Change], stop: int, noise: Noise, rounds: int = ROUNDS, but: int | None = None
    ) -> State:
        """Unknowns, amounts and variances of the runs before `stop`, beginning with some variances.

        Without run `but`, if there is one to be left out.
        """
        noise, found = noise.until(stop), None
        for _ in range(rounds):
            found = self._round(tuple(changes), stop, noise, but)
            noise = self._variances(found, noise)
        assert found is not None  # at least one round
        return replace(found, noise=noise)

    def _round(self, changes: tuple[Change, ...], stop: int, noise: Noise, but: int | None) -> State:
        given = self._until(stop, but)
        said, columns = says(*given, self.usual * noise.unit * noise.run), self._columns(changes, stop)
        mean, lower, score = self._posterior(changes, said, columns)
        score += float(np.sum(said.constant)) + self._rarity(noise, self._units(changes, stop))
        variance = self.usual * noise.unit * noise.run
        root, (normal, right) = np.sqrt(variance), given
        left = right - np.einsum("rmn,rn->rm", normal, columns @ mean)
        amounts = root * np.einsum("rmn,rn->rm", said.inverse, root * left)
        open_ = variance * np.diagonal(said.inverse, axis1=1, axis2=2)
        seen = 1.0 - open_ / variance
        if stop < KNOWN:
            open_ = open_ + self._open_level(said, columns, root, lower)
        deviations = (amounts**2 + open_) / (self.usual * noise.unit)
        return State(changes, stop, score, noise, mean, lower, deviations, seen)

    def _until(self, stop: int, but: int | None) -> tuple[np.ndarray, np.ndarray]:
        normal, right = (one[:stop] for one in self._given)
        if but is None:
            return normal, right
        others = np.arange(stop) != but
        return normal * others[:, None, None], right * others[:, None]

    def _open_level(self, said: Says, columns: np.ndarray, root: np.ndarray, lower: np.ndarray) -> np.ndarray:
        """What is open of deviations because the arm's unknowns are, shape (r, m)."""
        seen = root[:, :, None] * (np.eye(root.shape[1]) - said.inverse) / root[:, None, :]
        turned = (seen @ columns).reshape(-1, columns.shape[2])
        solved = linalg.solve_triangular(lower, turned.T, lower=True, check_finite=False)
        return np.sum(solved**2, axis=0).reshape(root.shape)

    def _units(self, changes: Sequence[Change], stop: int) -> list[slice]:
        """Runs of each unit that was under the arm's name."""
        edges = sorted({one.start for one in changes if self.suspects[one.suspect].name == EXCHANGE})
        return [slice(*one) for one in zip([0, *edges], [*edges, stop], strict=True)]

    def _variances(self, state: State, noise: Noise) -> Noise:
        """The most probable ones, by each run's deviations over the unit's variance."""
        tails, alike = self.scatter.tails, self.scatter.alike
        run = (tails + state.deviations) / (tails + 1.0)
        unit = noise.unit.copy()
        for rows in self._units(state.changes, state.stop):
            total = np.sum(noise.unit[rows] * state.deviations[rows] / run[rows], axis=0)
            unit[rows] = (alike + total) / (alike + len(run[rows]))
        return Noise(unit, run)

    def _rarity(self, noise: Noise, units: Sequence[slice]) -> float:
        """Logarithm of the probability of variances, per logarithm of them: of Student's distribution."""
        first = noise.unit[[rows.start for rows in units]]
        return 0.5 * (self.scatter.tails * _rare(noise.run) + _rare(first, self.scatter.alike))

    def _columns(self, changes: Sequence[Change], stop: int) -> np.ndarray:
        return np.concatenate(
            [self.runs.design[:stop], *(self.columns(one, stop) for one in changes)], axis=2
        )

    def _before(self, changes: Sequence[Change]) -> tuple[np.ndarray, np.ndarray]:
        """Mean and precision of unknowns and amounts before the runs, each (d + c,)."""
        units = self.learned.units
        stds = [self.std(one) ** -2.0 for one in changes]
        amounts = np.zeros(sum(len(one) for one in stds))
        return (
            np.concatenate([units.mean - self.level, amounts]),
            np.concatenate([1.0 / units.variance, *stds]),
        )

    def _posterior(
        self, changes: Sequence[Change], said: Says, columns: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """Mean and root of the precision; and the logarithm of the probability, all but constants."""
        before, weight = self._before(changes)
        weighted = said.normal @ columns
        flat = columns.reshape(-1, columns.shape[2])
        precision = flat.T @ weighted.reshape(flat.shape) + np.diag(weight)
        right = flat.T @ said.right.reshape(-1) + weight * before
        lower = linalg.cholesky(precision, lower=True, check_finite=False)
        half = linalg.solve_triangular(lower, right, lower=True, check_finite=False)
        mean = linalg.solve_triangular(lower, half, lower=True, trans=1, check_finite=False)
        score = 0.5 * (half @ half - before @ (weight * before) + np.sum(np.log(weight)))
        return mean, lower, float(score - np.sum(np.log(np.diag(lower))))

    def asked(
        self, state: State, starts: Sequence[int], noises: Sequence[Noise | None]
    ) -> list[list[Evidence]]:
        """What a further change from each of these runs on would explain, at once and creeping.

        Args:
            state: The runs as they are explained so far.
            starts: First runs after a change.
            noises: Variances of the runs from the change on, in turn; None for those of the state, by which a
                change counts for little, since runs after it explain themselves as being out of line.
        """
        own, before = self._sums(state, state.noise), self._before(state.changes)
        found = []
        for noise in noises:
            after, each = own if noise is None else self._sums(state, noise), list[Evidence]()
            for start in starts:
                series = {one: self.series(Change(0, start, one), state.stop) for one in SHAPES}
                each += evidence_from(start, series, own, after, *before)
            found.append(each)
        return found

    def _sums(self, state: State, noise: Noise) -> Sums:
        said = says(*self._until(state.stop, None), self.usual * noise.unit * noise.run)
        return Sums.of(said, self._columns(state.changes, state.stop), self.factor[: state.stop])

    def asked_of(self, state: State, run: int) -> Evidence:
        """What a change in one run only would explain, that run being usual otherwise."""
        usual = state.noise.run.copy()
        usual[run] = 1.0
        before, weight = self._before(state.changes)
        own = self._sums(state, Noise(state.noise.unit, usual))
        lower = linalg.cholesky(own.normal.sum(axis=0) + np.diag(weight), lower=True, check_finite=False)
        half = linalg.solve_triangular(lower, own.right.sum(axis=0) + weight * before, lower=True)
        turned = linalg.solve_triangular(lower, own.across[run], lower=True, check_finite=False)
        return Evidence(run, STEP, own.own[run] - turned.T @ turned, own.side[run] - turned.T @ half)

    def off(self, run: int, level: np.ndarray) -> np.ndarray:
        """Squared deviations of a run from an arm's unknowns over the usual variance, shape (m,)."""
        normal, right = (one[run] for one in self._given)
        left = right - normal @ (self.runs.design[run] @ (level - self.level))
        return np.asarray(np.linalg.solve(normal + np.diag(1.0 / self.usual), left) ** 2 / self.usual)


def _rare(variances: np.ndarray, freedom: np.ndarray | float = 1.0) -> float:
    return float(np.sum(freedom * (1.0 - np.log(variances) - 1.0 / variances)))
