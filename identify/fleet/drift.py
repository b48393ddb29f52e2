"""Drift: changes of an arm and their dates, by the likelihood of its runs, run after run.

After each run every suspect is tested for a change since one of the runs before, as a step or as a creep. A
change is accepted if its likelihood ratio exceeds its price: the number of runs among which one false alarm
is allowed, times the number of suspects and shapes. Amounts are integrated out, so the mean of the likelihood
ratio is one on an arm without changes. The sum of such ratios over all possible first runs (the
Shiryaev-Roberts statistic) therefore takes, on average, at least N runs to reach a bound of N.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from .evidence import CREEP, SHAPES
from .history import ROUNDS, YEAR, Change, History, Noise, State
from .learned import Learned
from .runs import ArmRuns
from .scatter import Scatter, scatter_of
from .strangers import Odd, exchanged_for, odd_runs
from .suspects import EXCHANGE, Suspect

NO_OTHERS: Mapping[str, np.ndarray] = MappingProxyType({})
FEWEST = 2
"""Minimum number of runs before and after a change: a single outlier is a bad run."""
LEAST = 2 * FEWEST
"""Minimum number of runs of an arm for a change."""
INSIDE_95 = 1.92
"""Log-likelihood ratio of the 95 % interval of a date: half of chi-squared with one degree of freedom."""
SETTLES = 5
"""Maximum number of passes over all changes; usually one is enough."""
OPEN = 3.0
"""Difference of log-likelihoods up to which a rival is not excluded: odds of 20."""
WORTH = 3.0
"""Minimum gain in log-likelihood for a suspect to be examined with its own variances, which takes longer."""
DATES = 3.0
"""Maximum contribution of other dates and shapes to the log-odds: twenty that are equally good."""
FEW = 4
"""Iterations of variances for the ranking of changes."""
CLOSER = 3
"""Maximum number of suspects to be examined."""


@dataclass(frozen=True, eq=False)
class DetectedChange:
    """A change of an arm, by all of its runs.

    Attributes:
        suspect: What changed.
        shape: `STEP` or `CREEP`.
        amounts: Present amount of each cause, in the cause's unit, shape (k,).
        stds: Standard deviations of the amounts, shape (k,).
        usual: Values of the causes before the first change, shape (k,); NaN where there is none.
        day: Day on which the change happened or began [d since 1970].
        interval: 95 % interval of that day [d].
        alarmed: Day on which the change was first detected [d].
        evidence: Log-odds of the change over no change, minus its price.
        rivals: Suspects that explain the runs nearly as well.
        either_shape: Whether step and creep explain the runs equally well.
        like: Arm of the fleet that took the place of an exchanged arm; empty for none.
    """

    suspect: Suspect
    shape: str
    amounts: np.ndarray
    stds: np.ndarray
    usual: np.ndarray
    day: float
    interval: tuple[float, float]
    alarmed: float
    evidence: float
    rivals: tuple[Suspect, ...]
    either_shape: bool
    like: str

    @property
    def surest(self) -> int:
        """Index of the most certain amount."""
        return int(np.argmax(np.abs(self.amounts) / self.stds))


@dataclass(frozen=True, eq=False)
class ArmDrift:
    """Changes of one arm.

    Attributes:
        changes: Changes by date, without those that later runs did not confirm.
        alarms: Days on which an alarm was raised.
        odd: Outlier runs, which are not caused by a change.
        price: Log-odds from which a change is accepted.
        level: The arm's unknowns before any change, shape (d,). They include those of temperature, so that
            temperature effects do not count as changes.
    """

    changes: tuple[DetectedChange, ...]
    alarms: tuple[float, ...]
    odd: tuple[Odd, ...]
    price: float
    level: np.ndarray


def drift(
    learned: Learned,
    runs: ArmRuns,
    alarms_per_year: float,
    scatter: Scatter,
    others: Mapping[str, np.ndarray] = NO_OTHERS,
) -> ArmDrift:
    """Changes and outlier runs of one arm.

    Args:
        learned: Statistics of the arm's type.
        runs: Runs of the arm.
        alarms_per_year: Number of false alarms allowed per year.
        scatter: Scatter of the arm's type.
        others: Unknowns of the other arms, of which a run may have been filed under this arm.
    """
    history, count = History(learned, runs, scatter), len(runs.runs)
    search = Search(history, price_of(history, alarms_per_year))
    if count < LEAST:
        return ArmDrift((), (), (), search.price, history.level)
    state: State | None = None
    alarms = list[tuple[float, Change]]()
    noise = history.quiet(LEAST)
    for stop in range(LEAST, count + 1):
        before: tuple[Change, ...] = state.changes if state else ()
        known = {change.suspect for change in before}  # a new date or shape is not a new alarm
        state = search.further(history.explained(before, stop, noise, 2 if state else 6), windows(stop))
        raised = [change for change in state.changes if change.suspect not in known]
        alarms += [(float(runs.days[stop - 1]), change) for change in raised]
        noise = state.noise
    assert state is not None  # the loop ran at least once
    state = search.settled(state)
    days = [day for day, _ in alarms]
    changes = [_detected(search, state, index, days, others) for index in range(len(state.changes))]
    changes.sort(key=lambda change: change.day)
    odd = odd_runs(history, state, runs_allowed(history, alarms_per_year), others)
    level = history.level + state.mean[: len(history.level)]
    return ArmDrift(tuple(changes), tuple(days), tuple(odd), search.price, level)


def at_first(learned: Learned, runs: ArmRuns, alarms_per_year: float) -> State | None:
    """Explanation of all runs of an arm before the scatter of its type is known."""
    history = History(learned, runs, Scatter.first(len(learned.frame.scale)))
    stop = len(runs.runs)
    if stop < LEAST:
        return None
    search = Search(history, price_of(history, alarms_per_year))
    return search.further(history.explained((), stop, history.quiet(stop)), windows(stop))


def scatter_among(learned: Learned, states: Mapping[str, State | None]) -> Scatter:
    """Scatter of the runs of a type, by the current explanations of all its arms."""
    frame, squares, seen = learned.frame, [], []
    groups = [""] * len(frame.scale)
    for cause in frame.causes:
        place = frame.unknown_of(cause)
        if cause.wears and place >= 0:
            groups[place] = cause.effect
    for arm, state in states.items():
        if state is not None:
            known_payload = ~learned.arms[arm].loose
            squares.append((state.deviations * state.noise.unit)[known_payload])
            seen.append(state.seen[known_payload])
    return scatter_of(squares, seen, groups) if squares else Scatter.first(len(groups))


def price_of(history: History, alarms_per_year: float) -> float:
    """Log-odds that are reached by chance once in the number of allowed runs, on average."""
    runs = runs_allowed(history, alarms_per_year)
    return float(np.log(runs * len(history.suspects) * len(SHAPES)))


def runs_allowed(history: History, alarms_per_year: float) -> float:
    """Number of runs among which one false alarm is allowed."""
    days = history.runs.days
    spacing = float(np.median(np.diff(days))) if len(days) > 1 else 1.0
    return max(YEAR / max(spacing, 1e-3) / alarms_per_year, 1.0)


def windows(stop: int) -> list[int]:
    """First runs after a change that are tested after run `stop`: at growing distances from two runs on."""
    back, starts = float(FEWEST), list[int]()
    while stop - round(back) >= FEWEST:
        starts.append(stop - round(back))
        back *= 1.5
    return sorted({*starts, *([FEWEST] if stop >= LEAST else [])})


def _starts(stop: int) -> list[int]:
    """All possible first runs after a change."""
    return list(range(FEWEST, stop - FEWEST + 1))


@dataclass(frozen=True, eq=False)
class Search:
    """Search for changes of one arm that are worth their price."""

    history: History
    price: float

    def further(self, state: State, starts: Sequence[int]) -> State:
        """The state with changes added or replaced as long as they are worth their price."""
        while True:
            extended = self._best(state, starts)
            if extended is None or extended.score - state.score < self.price - DATES:
                return state
            state, extended = self._converged(state, extended)
            if self.odds(state, extended, extended.changes[-1]) < self.price:
                return state
            if self._is_single_run(state, extended):
                return state
            replaced = [self._replaced(state, index, starts) for index in range(len(state.changes))]
            best = max([other for other in replaced if other], key=lambda other: other.score, default=None)
            # Another shape or date of a change is free, but an additional change has its price.
            state = best if best is not None and best.score > extended.score - self.price else extended

    def odds(self, without: State, state: State, change: Change) -> float:
        """Log-odds of a change over no change, over all its dates and shapes."""
        [gains] = self._gains(without, sorted({*windows(state.stop), change.start}), [state.noise])
        dated = {other: gain for gain, other in gains if other.suspect == change.suspect}
        contribution = np.logaddexp.reduce(list(dated.values())) - dated[change]
        return state.score - without.score + min(float(contribution), DATES)

    def _converged(self, state: State, extended: State) -> tuple[State, State]:
        """Both states with converged variances, so that iterations alone give neither an advantage."""
        explained, stop = self.history.explained, state.stop
        versions = [explained(state.changes, stop, start.noise, ROUNDS) for start in (state, extended)]
        best = max(versions, key=lambda version: version.score)
        return best, explained(extended.changes, stop, extended.noise, ROUNDS)

    def _is_single_run(self, state: State, extended: State) -> bool:
        """Whether the last change has no support without the run that it explains best."""
        first = extended.changes[-1].start
        improvement = np.sum(np.log(state.noise.run[first:]) - np.log(extended.noise.run[first:]), axis=1)
        run, stop = first + int(np.argmax(improvement)), state.stop
        scores = [
            self.history.explained(version.changes, stop, version.noise, left_out=run).score
            for version in (state, extended)
        ]
        return scores[1] < scores[0]

    def settled(self, state: State) -> State:
        """The state after all changes were replaced by better ones, and those below their price removed."""
        for _ in range(SETTLES):
            before = state.changes
            for index in range(len(before)):
                replaced = self._replaced(state, index, _starts(state.stop))
                state = replaced if replaced is not None and replaced.score > state.score else state
            if state.changes == before:
                break
        for index in reversed(range(len(state.changes))):
            without = self.without(state, index)
            if self.odds(without, state, state.changes[index]) < self.price:
                state = without
        return state

    def without(self, state: State, index: int) -> State:
        """The state without one of its changes."""
        remaining = state.changes[:index] + state.changes[index + 1 :]
        return self.history.explained(remaining, state.stop, state.noise)

    def _replaced(self, state: State, index: int, starts: Sequence[int]) -> State | None:
        """The state with one change replaced by the best alternative."""
        change = state.changes[index]
        best = self._best(self.without(state, index), sorted({*starts, change.start}))
        if best is None:
            return None
        *others, new = best.changes
        return self.history.explained((*others[:index], new, *others[index:]), state.stop, best.noise, 1)

    def _best(self, state: State, starts: Sequence[int]) -> State | None:
        """The state with the most probable additional change; None if no change is worth examining."""
        extended = [
            self.history.explained((*state.changes, change), state.stop, noise, FEW)
            for change in self._candidates(state, starts)
            for noise in (state.noise.usual_from(change.start),)
        ]
        return max(extended, key=lambda other: other.score, default=None)

    def _candidates(self, state: State, starts: Sequence[int]) -> list[Change]:
        """The best change of a few suspects, with noise of the state and with noise reset from the start."""
        chosen = dict[Change, None]()
        for gains in self._gains(state, starts, [None, state.noise.usual_from(FEWEST)]):
            examined = set[int]()
            for gain, change in sorted(gains, reverse=True):
                if gain < WORTH or len(examined) == CLOSER:
                    break
                if change.suspect not in examined:
                    examined.add(change.suspect)
                    chosen[change] = None
        return list(chosen)

    def _gains(
        self, state: State, starts: Sequence[int], noises: Sequence[Noise | None]
    ) -> list[list[tuple[float, Change]]]:
        """Gain of each possible additional change, one list for each noise of the runs after it."""
        return [
            [
                (float(gain), Change(suspect, evidence.start, evidence.shape))
                for evidence in evidences
                for suspect, gain in enumerate(evidence.gains(self.history.questions))
                if np.isfinite(gain)
            ]
            for evidences in self.history.evidence(state, starts, noises)
        ]


def _detected(
    search: Search, state: State, index: int, alarms: Sequence[float], arms: Mapping[str, np.ndarray]
) -> DetectedChange:
    """A change with its date, the interval of the date, and its rivals, while other changes stay."""
    history, change = search.history, state.changes[index]
    without, days = search.without(state, index), search.history.runs.days
    same_noise = replace(without, noise=state.noise)
    [gains] = search._gains(same_noise, _starts(state.stop), [None])
    by_start = {other.start: gain for gain, other in gains if other[::2] == change[::2]}
    top = by_start.get(change.start, max(by_start.values()))
    inside = [start for start, gain in by_start.items() if gain > top - INSIDE_95]
    first, last = min([*inside, change.start]), max([*inside, change.start])
    begin = change.start - 1
    suspect = history.suspects[change.suspect]
    amounts, stds = _amounts(history, state, index)
    rivals = {
        other.suspect: gain
        for gain, other in sorted(gains)
        if gain > top - OPEN and other.suspect != change.suspect
    }
    shapes = {other.shape for gain, other in gains if gain > top - OPEN and other.suspect == change.suspect}
    return DetectedChange(
        suspect=suspect,
        shape=change.shape,
        amounts=amounts,
        stds=stds,
        usual=_usual(history, state, suspect),
        day=float(days[begin] if change.shape == CREEP else 0.5 * (days[begin] + days[begin + 1])),
        interval=(float(days[first - 1]), float(days[last])),
        alarmed=_first_seen(search, state, index, alarms),
        evidence=state.score - without.score - search.price,
        rivals=tuple(history.suspects[k] for k in sorted(rivals, key=lambda k: -rivals[k])),
        either_shape=len(shapes | {change.shape}) > 1,
        like=exchanged_for(history, change, arms) if suspect.name == EXCHANGE else "",
    )


def _first_seen(search: Search, state: State, index: int, alarms: Sequence[float]) -> float:
    """Day of the first alarm that the change can have raised; else the day when it was worth its price.

    A change cannot cause an alarm before two runs show it.
    """
    history, change = search.history, state.changes[index]
    days, first = history.runs.days, change.start + FEWEST
    after = [day for day in alarms if day >= days[first - 1]]
    if after:
        return after[0]
    for stop in range(first, state.stop):
        until = tuple(other for other in state.changes if other.start <= stop - FEWEST)
        others = tuple(other for other in until if other != change)
        scores = [history.explained(changes, stop, state.noise).score for changes in (until, others)]
        if scores[0] - scores[1] > search.price:
            return float(days[stop - 1])
    return float(days[state.stop - 1])


def _amounts(history: History, state: State, index: int) -> tuple[np.ndarray, np.ndarray]:
    sizes = [len(history.std(change)) for change in state.changes]
    first = len(history.level) + sum(sizes[:index])
    rows = slice(first, first + sizes[index])
    inverse = np.linalg.inv(state.lower)[:, rows]
    return state.mean[rows], np.sqrt(np.sum(inverse**2, axis=0))


def _usual(history: History, state: State, suspect: Suspect) -> np.ndarray:
    """Reference values for relative changes: values before the first change, or one for shares."""
    frame = history.learned.frame
    values = (history.level + state.mean[: len(history.level)])[: len(frame.scale)] * frame.scale
    causes = [frame.causes[k] for k in suspect.causes] if suspect.name != EXCHANGE else []
    return np.array(
        [1.0 if not cause.unit else values[cause.place] if cause.place >= 0 else np.nan for cause in causes]
    )
