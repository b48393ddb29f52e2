"""Drift: when what changed on an arm, by likelihood over all causes together, run after run.

After each run, every cause is asked whether it has changed since one of the runs before, at once or creeping
since. Temperature, load and all earlier changes are unknowns beside it. An alarm is the best answer beyond
a threshold that all the questions of a year together exceed as often as the user allows.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import linalg, stats

from .learned import Learned
from .runs import ArmRuns

STEP, CREEP = SHAPES = "step", "creep"
FEWEST = 2
"""Runs before and after a change: a single run out of line is a bad run."""
LEAST = 2 * FEWEST
"""Runs of an arm from which on a change is asked for."""
YEAR = 365.25
ANY = 1e6
"""Standard deviation of a change before the data, in the frame's units: nothing is known."""
NORMAL_95 = 3.84
"""Twice the logarithm of a likelihood ratio within which a date lies with 95 %: chi-squared, one freedom."""
PLAUSIBLE = (0.2, 5.0)
"""Friction at a temperature over that at the reference, at least and at most [-]."""
OPEN = 3.0
"""Difference of log-likelihoods up to which another answer is not excluded: odds of 20."""


class Change(NamedTuple):
    """A cause that changes: at once before run `start`, or creeping since the run before it.

    Attributes:
        cause: Its place among the frame's.
        start: First run after the change.
        shape: `STEP` or `CREEP`.
    """

    cause: int
    start: int
    shape: str


class Answer(NamedTuple):
    """A change, and how sure it is.

    Attributes:
        change: What.
        amount: Of the cause, in its unit; of one that creeps, a year.
        std: Of the amount.
        deviations: The amount over its standard deviation, without sign.
    """

    change: Change
    amount: float
    std: float
    deviations: float

    @property
    def evidence(self) -> float:
        """Logarithm of the likelihood ratio to no change."""
        return 0.5 * self.deviations**2


@dataclass(frozen=True)
class Found:
    """A change of an arm, all its runs considered.

    Attributes:
        cause: Place among the frame's causes.
        shape: `STEP` or `CREEP`.
        amount: By now, in the cause's unit.
        std: Of the amount.
        day: When it changed, or began to [d since 1970].
        interval: In which that lies with 95 % [d].
        alarmed: When it was first seen [d].
        deviations: Amount over its standard deviation.
        usual: Value before; NaN where there is none.
        others: Causes that explain it nearly as well, and are not excluded.
        either: Whether step and creep explain it alike.
    """

    cause: int
    shape: str
    amount: float
    std: float
    day: float
    interval: tuple[float, float]
    alarmed: float
    deviations: float
    usual: float
    others: tuple[int, ...]
    either: bool

    @property
    def share(self) -> tuple[float, float]:
        """Amount and its deviation over the usual value; not finite where there is none."""
        return self.amount / abs(self.usual), self.std / abs(self.usual)


@dataclass(frozen=True)
class ArmDrift:
    """What changed on one arm.

    Attributes:
        found: Changes, by date; those of alarms that later runs did not confirm are left out.
        alarms: Days on which one was raised.
        threshold: Deviations from which a change is believed.
        level: Mean and
        covariance: of its unknowns before the first change, in the frame's units.
    """

    found: tuple[Found, ...]
    alarms: tuple[float, ...]
    threshold: float
    level: np.ndarray
    covariance: np.ndarray


def drift(learned: Learned, runs: ArmRuns, alarms_per_year: float) -> ArmDrift:
    """Changes of one arm; as many false alarms a year are allowed."""
    history, changes, alarms = _History(learned, runs), list[Change](), list[tuple[float, int]]()
    threshold = threshold_of(learned, runs, alarms_per_year)
    for stop in range(LEAST, len(runs.runs) + 1):
        changes = _again(history, changes, stop)
        best = history.best(changes, stop, windows(stop))
        while best.deviations > threshold and len(changes) < stop // FEWEST:
            alarms.append((float(runs.days[stop - 1]), len(changes)))
            changes = _again(history, [*changes, best.change], stop)
            best = history.best(changes, stop, windows(stop))
    whole = len(runs.runs)
    first = {place: day for day, place in reversed(alarms)}
    found = [_found(history, changes, place, first[place], whole) for place in range(len(changes))]
    level, covariance = learned.units.posterior(*history.sums(changes, whole, own=True))
    ordered = tuple(sorted((one for one in found if one.deviations > threshold), key=lambda one: one.day))
    return ArmDrift(ordered, tuple(day for day, _ in alarms), threshold, level, covariance)


def threshold_of(learned: Learned, runs: ArmRuns, alarms_per_year: float) -> float:
    """Deviations that all questions of a year together exceed so often at most, by Bonferroni.

    Student's distribution stands for the scatter being estimated from a number of pairs of runs.
    """
    spacing = np.median(np.diff(runs.days)) if len(runs.days) > 1 else 1.0
    questions = YEAR / max(float(spacing), 1e-3) * len(learned.frame.causes) * len(SHAPES)
    questions *= max(len(windows(len(runs.runs))), 1)  # none yet where runs are too few for a change
    share = min(alarms_per_year / questions, 1.0)
    return float(stats.t.isf(0.5 * share, max(learned.freedom - 1, 1)))


def windows(stop: int) -> list[int]:
    """First runs after a change that are asked for after run `stop`: two runs back, and ever farther."""
    back, found = float(FEWEST), list[int]()
    while stop - round(back) >= FEWEST:
        found.append(stop - round(back))
        back *= 1.5
    return sorted({*found, *([FEWEST] if stop >= LEAST else [])})


@dataclass(frozen=True, eq=False)
class _History:
    """Normal matrices of one arm's runs, changes as columns beside its unknowns."""

    learned: Learned
    runs: ArmRuns
    _kept: dict = field(default_factory=dict)

    @cached_property
    def says(self) -> tuple[np.ndarray, np.ndarray]:
        return self.learned.says(self.runs)

    @property
    def directions(self) -> np.ndarray:
        return self.learned.frame.directions

    def series(self, change: Change) -> np.ndarray:
        """How much of a change each run has, shape (r,): none or one; or years since it began."""
        days = self.runs.days
        if change.shape == STEP:
            return (np.arange(len(days)) >= change.start).astype(float)
        return np.maximum(days - days[change.start - 1], 0.0) / YEAR

    def sums(self, changes: list[Change], stop: int, own: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """Sums over runs before `stop`; of the arm's own unknowns with changes solved for, if asked."""
        normal, right, _ = self._cumulated(changes)
        if not own or not changes:
            return normal[stop - 1], right[stop - 1]
        count = len(self.learned.units.mean)
        whole, side = normal[stop - 1], right[stop - 1]
        inner = whole[count:, count:] + np.eye(len(changes)) / ANY**2
        taken = np.linalg.solve(inner, np.column_stack([whole[count:, :count], side[count:]]))
        less = whole[:count, count:] @ taken
        return whole[:count, :count] - less[:, :-1], side[:count] - less[:, -1]

    def _cumulated(self, changes: list[Change]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Cumulated normal matrices (r, d, d) and right-hand sides (r, d); products with causes (r, d, k)."""
        key = tuple(changes)
        if key not in self._kept:
            self._kept.clear()
            normal, right = self.says
            factor = self._factor
            columns = [
                (self.series(one) * factor[:, one.cause])[:, None] * self.directions[one.cause]
                for one in changes
            ]
            design = np.concatenate([self.runs.design, *(column[:, :, None] for column in columns)], axis=2)
            turned = np.swapaxes(design, 1, 2)
            sums = np.cumsum(turned @ (normal @ design), axis=0)
            products = turned @ (normal @ self.directions.T) * factor[:, None, :]
            self._kept[key] = sums, np.cumsum(np.einsum("rdm,rm->rd", turned, right), axis=0), products
        return self._kept[key]

    @cached_property
    def _own(self) -> tuple[np.ndarray, np.ndarray]:
        """Each cause's own normal number and right-hand side in each run, shapes (r, k)."""
        normal, right = self.says
        directions, factor = self.directions, self._factor
        squares = np.einsum("km,rmn,kn->rk", directions, normal, directions, optimize=True)
        return squares * factor**2, (right @ directions.T) * factor

    @cached_property
    def _factor(self) -> np.ndarray:
        """Friction at a run's temperature over that at the reference, shape (r, k); one for all else.

        A worn bearing has so much more friction, in per cent, warm or cold.
        """
        frame, found = self.learned.frame, np.ones((len(self.runs.days), len(self.directions)))
        level, _ = self.learned.level(self.runs)
        in_runs = self.runs.design @ level
        for k in frame.thermal:
            place = frame.causes[k].place
            if abs(level[place]) > 1.0:  # more than units differ by: not near zero
                found[:, k] = np.clip(in_runs[:, place] / level[place], *PLAUSIBLE)
        return found

    def asked(self, changes: list[Change], stop: int, starts: list[int]) -> tuple[np.ndarray, np.ndarray]:
        """Amounts of every cause and their deviations by runs before `stop`, each (shapes, starts, k)."""
        sums, rights, products = self._cumulated(changes)
        units = self.learned.units
        precision = np.concatenate([1.0 / units.variance, np.full(len(changes), ANY**-2.0)])
        root = linalg.cholesky(sums[stop - 1] + np.diag(precision), lower=True, check_finite=False)
        right = rights[stop - 1] + np.append(units.mean / units.variance, np.zeros(len(changes)))
        right = linalg.solve_triangular(root, right, lower=True, check_finite=False)
        rows = np.array([self.series(Change(0, start, shape))[:stop] for shape in SHAPES for start in starts])
        normal, side = self._own
        across = np.tensordot(rows, products[:stop], axes=1)  # (s, d, k)
        count, size, causes = across.shape
        flat = np.swapaxes(across, 0, 1).reshape(size, -1)
        flat = linalg.solve_triangular(root, flat, lower=True, check_finite=False)
        explained = np.sum(flat**2, axis=0).reshape(count, causes)
        own = rows**2 @ normal[:stop]
        left = np.maximum(own - explained, 1e-9 * own + np.finfo(float).tiny)
        amount = (rows @ side[:stop] - (right @ flat).reshape(count, causes)) / left
        shape = (len(SHAPES), len(starts), causes)
        return amount.reshape(shape), (1.0 / np.sqrt(left)).reshape(shape)

    def best(self, changes: list[Change], stop: int, starts: list[int]) -> Answer:
        """The change that makes the runs most probable."""
        amount, std = self.asked(changes, stop, starts)
        place = np.unravel_index(np.argmax(np.abs(amount) / std), amount.shape)
        shape, start, cause = (int(one) for one in place)
        change = Change(cause, starts[start], SHAPES[shape])
        return Answer(change, float(amount[place]), float(std[place]), float(abs(amount[place]) / std[place]))


def _again(history: _History, changes: list[Change], stop: int) -> list[Change]:
    """Each change in turn as the runs so far show it, the others held."""
    for place, change in enumerate(changes):
        others = changes[:place] + changes[place + 1 :]
        best = history.best(others, stop, sorted({*windows(stop), change.start}))
        changes = [*changes[:place], best.change, *changes[place + 1 :]]
    return changes


def _found(history: _History, changes: list[Change], place: int, alarmed: float, stop: int) -> Found:
    """A change with its date, its interval and what it might be instead, the others held."""
    others = changes[:place] + changes[place + 1 :]
    starts = list(range(FEWEST, stop - FEWEST + 1))
    amounts, stds = history.asked(others, stop, starts)
    evidence = 0.5 * (amounts / stds) ** 2
    shape, start, cause = (int(one) for one in np.unravel_index(np.argmax(evidence), evidence.shape))
    top, days = evidence[shape, start, cause], history.runs.days
    inside = [starts[k] for k in np.flatnonzero(evidence[shape, :, cause] > top - 0.5 * NORMAL_95)]
    by_cause, by_shape = evidence.max(axis=(0, 1)), evidence.max(axis=(1, 2))
    by_now = float(history.series(Change(cause, starts[start], SHAPES[shape]))[stop - 1])
    before = starts[start] - 1
    return Found(
        cause=cause,
        shape=SHAPES[shape],
        amount=by_now * float(amounts[shape, start, cause]),
        std=by_now * float(stds[shape, start, cause]),
        day=float(days[before] if shape else 0.5 * (days[before] + days[before + 1])),
        interval=(float(days[inside[0] - 1]), float(days[inside[-1]])),
        alarmed=alarmed,
        deviations=float(np.sqrt(2.0 * top)),
        usual=_usual(history, cause),
        others=tuple(int(k) for k in np.argsort(-by_cause) if k != cause and by_cause[k] > top - OPEN),
        either=bool(np.min(by_shape) > top - OPEN),
    )


def _usual(history: _History, cause: int) -> float:
    """The value of which a change is a share: of the arm's usual unknowns, or one."""
    frame = history.learned.frame
    one = frame.causes[cause]
    if not one.unit:
        return 1.0
    if one.place < 0:
        return float("nan")
    return float((history.learned.level(history.runs)[0][: len(frame.scale)] * frame.scale)[one.place])
