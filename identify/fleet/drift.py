"""Drift: what changed on an arm and when, by the probability of its runs, run after run.

After each run every suspect is asked whether it has changed since one of the runs before, at once or
creeping since. A change is believed where the runs are more probable with it by more than its price: the
number of runs among which one false alarm is allowed, times the number of suspects and shapes. Amounts are
integrated out, so that this factor is a likelihood ratio, whose mean is one on an arm of which nothing
changed; the sum of such ratios over all runs on which it may have begun (Shiryaev's and Roberts's)
therefore reaches a bound no earlier, on average, than after as many runs.
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
"""Runs before and after a change: a single run out of line is a bad run."""
LEAST = 2 * FEWEST
"""Runs of an arm from which on a change is asked for."""
INSIDE_95 = 1.92
"""Logarithm of a likelihood ratio within which a date lies with 95 %: half of chi-squared, one freedom."""
SETTLES = 5
"""Times that all changes are looked at again at most; usually one is enough."""
OPEN = 3.0
"""Difference of log-likelihoods up to which another answer is not excluded: odds of 20."""
WORTH = 3.0
"""The same from which a suspect is asked with variances of its own, which takes longer."""
DATES = 3.0
"""What dates and shapes nearly as good add to the logarithm of odds, at most: twenty of them."""
FEW = 4
"""Rounds of variances by which changes are ranked."""
CLOSER = 3
"""So many suspects are, at most."""


@dataclass(frozen=True, eq=False)
class Found:
    """A change of an arm, all its runs considered.

    Attributes:
        suspect: What happened.
        shape: `STEP` or `CREEP`.
        amounts: Of each of its causes by now, in the cause's unit, shape (k,), and
        stds: their standard deviations.
        usual: Values of the causes before the first change, shape (k,); NaN where there is none.
        day: When it changed, or began to [d since 1970].
        interval: In which that lies with 95 % [d].
        alarmed: When it was first seen [d].
        evidence: Logarithm of the odds of it over nothing, its price subtracted.
        others: Suspects that explain it nearly as well, and are not excluded.
        either: Whether step and creep explain it alike.
        like: Of another arm, which one of the fleet it is; empty for none.
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
    others: tuple[Suspect, ...]
    either: bool
    like: str

    @property
    def surest(self) -> int:
        """Place of its surest consequence."""
        return int(np.argmax(np.abs(self.amounts) / self.stds))


@dataclass(frozen=True, eq=False)
class ArmDrift:
    """What changed on one arm.

    Attributes:
        found: Changes, by date; those of alarms that later runs did not confirm are left out.
        alarms: Days on which one was raised.
        odd: Runs out of line, which are no change.
        price: Logarithm of the odds from which a change is believed.
        level: The arm's unknowns before any change, temperature's included, shape (d,): a change is not taken
            for what temperature does.
    """

    found: tuple[Found, ...]
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
    """Changes of one arm, whose runs scatter so, and its runs out of line.

    Args:
        learned: What arms of its type teach.
        runs: Of the arm.
        alarms_per_year: False alarms that are allowed.
        scatter: Of its type.
        others: Unknowns of the other arms, whose runs may lie among its own.
    """
    history, whole = History(learned, runs, scatter), len(runs.runs)
    search = Search(history, price_of(history, alarms_per_year))
    if whole < LEAST:
        return ArmDrift((), (), (), search.price, history.level)
    state: State | None = None
    alarms = list[tuple[float, Change]]()
    noise = history.quiet(LEAST)
    for stop in range(LEAST, whole + 1):
        before: tuple[Change, ...] = state.changes if state else ()
        known = {one.suspect for one in before}  # of another date or shape it is the same alarm
        state = search.further(history.explained(before, stop, noise, 2 if state else 6), windows(stop))
        raised = [one for one in state.changes if one.suspect not in known]
        alarms += [(float(runs.days[stop - 1]), one) for one in raised]
        noise = state.noise
    assert state is not None  # one run at least was asked
    state = search.settled(state)
    days = [day for day, _ in alarms]
    found = [_found(search, state, place, days, others) for place in range(len(state.changes))]
    found.sort(key=lambda one: one.day)
    odd = odd_runs(history, state, runs_allowed(history, alarms_per_year), others)
    level = history.level + state.mean[: len(history.level)]
    return ArmDrift(tuple(found), tuple(days), tuple(odd), search.price, level)


def at_first(learned: Learned, runs: ArmRuns, alarms_per_year: float) -> State | None:
    """All runs of an arm as they are explained before it is known how those of its type scatter."""
    history = History(learned, runs, Scatter.first(len(learned.frame.scale)))
    stop = len(runs.runs)
    if stop < LEAST:
        return None
    search = Search(history, price_of(history, alarms_per_year))
    return search.further(history.explained((), stop, history.quiet(stop)), windows(stop))


def scatter_among(learned: Learned, states: Mapping[str, State | None]) -> Scatter:
    """How runs of a type scatter, by all its arms as they are explained so far."""
    frame, squares, seen = learned.frame, [], []
    groups = [""] * len(frame.scale)
    for one in frame.causes:
        place = len(frame.kind.base.kept) + one.joint if one.effect == "drive_gain" else one.place
        if one.wears and place >= 0:
            groups[place] = one.effect
    for arm, state in states.items():
        if state is not None:
            own = ~learned.arms[arm].loose
            squares.append((state.deviations * state.noise.unit)[own])
            seen.append(state.seen[own])
    return scatter_of(squares, seen, groups) if squares else Scatter.first(len(groups))


def price_of(history: History, alarms_per_year: float) -> float:
    """Logarithm of the odds that are reached by chance after as many runs as are allowed, on average."""
    runs = runs_allowed(history, alarms_per_year)
    return float(np.log(runs * len(history.suspects) * len(SHAPES)))


def runs_allowed(history: History, alarms_per_year: float) -> float:
    """Runs among which one false alarm is allowed."""
    days = history.runs.days
    spacing = float(np.median(np.diff(days))) if len(days) > 1 else 1.0
    return max(YEAR / max(spacing, 1e-3) / alarms_per_year, 1.0)


def windows(stop: int) -> list[int]:
    """First runs after a change that are asked for after run `stop`: two runs back, and ever farther."""
    back, found = float(FEWEST), list[int]()
    while stop - round(back) >= FEWEST:
        found.append(stop - round(back))
        back *= 1.5
    return sorted({*found, *([FEWEST] if stop >= LEAST else [])})


def _starts(stop: int) -> list[int]:
    """First runs after a change that are possible."""
    return list(range(FEWEST, stop - FEWEST + 1))


@dataclass(frozen=True, eq=False)
class Search:
    """For changes of one arm that are worth their price."""

    history: History
    price: float

    def further(self, state: State, starts: Sequence[int]) -> State:
        """With changes added as long as one is worth its price; or those of before explained otherwise."""
        while True:
            more = self._best(state, starts)
            if more is None or more.score - state.score < self.price - DATES:
                return state
            state, more = self._closely(state, more)
            if self.odds(state, more, more.changes[-1]) < self.price or self._of_one_run(state, more):
                return state
            others = [self._instead(state, place, starts) for place in range(len(state.changes))]
            best = max([one for one in others if one], key=lambda one: one.score, default=None)
            # a change of another shape or date costs nothing, one more costs its price
            state = best if best is not None and best.score > more.score - self.price else more

    def odds(self, without: State, state: State, change: Change) -> float:
        """Logarithm of the odds of a change over none, whenever it began, at once or creeping."""
        [asked] = self._asked(without, sorted({*windows(state.stop), change.start}), [state.noise])
        dated = {one: gain for gain, one in asked if one.suspect == change.suspect}
        others = np.logaddexp.reduce(list(dated.values())) - dated[change]
        return state.score - without.score + min(float(others), DATES)

    def _closely(self, state: State, more: State) -> tuple[State, State]:
        """Both with variances that have settled, so that neither is ahead by its rounds alone."""
        explained, stop = self.history.explained, state.stop
        own = [explained(state.changes, stop, one.noise, ROUNDS) for one in (state, more)]
        best = max(own, key=lambda one: one.score)
        return best, explained(more.changes, stop, more.noise, ROUNDS)

    def _of_one_run(self, state: State, more: State) -> bool:
        """Whether a change is one run's: nothing speaks for it without the run that it explains best."""
        first = more.changes[-1].start
        stranger = np.sum(np.log(state.noise.run[first:]) - np.log(more.noise.run[first:]), axis=1)
        run, stop = first + int(np.argmax(stranger)), state.stop
        scores = [
            self.history.explained(one.changes, stop, one.noise, but=run).score for one in (state, more)
        ]
        return scores[1] < scores[0]

    def settled(self, state: State) -> State:
        """Each change in turn as all runs show it, until none moves; those that are not worth it left out."""
        for _ in range(SETTLES):
            before = state.changes
            for place in range(len(before)):
                instead = self._instead(state, place, _starts(state.stop))
                state = instead if instead is not None and instead.score > state.score else state
            if state.changes == before:
                break
        for place in reversed(range(len(state.changes))):
            without = self.without(state, place)
            if self.odds(without, state, state.changes[place]) < self.price:
                state = without
        return state

    def without(self, state: State, place: int) -> State:
        """All but one of the changes."""
        left = state.changes[:place] + state.changes[place + 1 :]
        return self.history.explained(left, state.stop, state.noise)

    def _instead(self, state: State, place: int, starts: Sequence[int]) -> State | None:
        """The best change in place of one."""
        own = state.changes[place]
        found = self._best(self.without(state, place), sorted({*starts, own.start}))
        if found is None:
            return None
        *others, new = found.changes
        return self.history.explained((*others[:place], new, *others[place:]), state.stop, found.noise, 1)

    def _best(self, state: State, starts: Sequence[int]) -> State | None:
        """With the one change more that makes the runs most probable; None where none is worth asking."""
        found = [
            self.history.explained((*state.changes, one), state.stop, noise, FEW)
            for one in self._candidates(state, starts)
            for noise in (state.noise.usual_from(one.start),)
        ]
        return max(found, key=lambda one: one.score, default=None)

    def _candidates(self, state: State, starts: Sequence[int]) -> list[Change]:
        """The best of a few suspects, by runs as usual since then, and by runs that explain themselves."""
        chosen = dict[Change, None]()
        for asked in self._asked(state, starts, [None, state.noise.usual_from(FEWEST)]):
            names = set[int]()
            for gain, change in sorted(asked, reverse=True):
                if gain < WORTH or len(names) == CLOSER:
                    break
                if change.suspect not in names:
                    names.add(change.suspect)
                    chosen[change] = None
        return list(chosen)

    def _asked(
        self, state: State, starts: Sequence[int], noises: Sequence[Noise | None]
    ) -> list[list[tuple[float, Change]]]:
        """All changes that may be added, with their gains, by each of several noises of the runs after."""
        return [
            [
                (float(gain), Change(place, one.start, one.shape))
                for one in each
                for place, gain in enumerate(one.gains(self.history.questions))
                if np.isfinite(gain)
            ]
            for each in self.history.asked(state, starts, noises)
        ]


def _found(
    search: Search, state: State, place: int, alarms: Sequence[float], arms: Mapping[str, np.ndarray]
) -> Found:
    """A change with its date, its interval and what it might be instead, the others held."""
    history, change = search.history, state.changes[place]
    without, days = search.without(state, place), search.history.runs.days
    held = replace(without, noise=state.noise)
    [asked] = search._asked(held, _starts(state.stop), [None])
    own = {one.start: gain for gain, one in asked if one[::2] == change[::2]}
    top = own.get(change.start, max(own.values()))
    inside = [start for start, gain in own.items() if gain > top - INSIDE_95]
    first, last = min([*inside, change.start]), max([*inside, change.start])
    begin = change.start - 1
    suspect = history.suspects[change.suspect]
    amounts, stds = _amounts(history, state, place)
    others = {
        one.suspect: gain
        for gain, one in sorted(asked)
        if gain > top - OPEN and one.suspect != change.suspect
    }
    shapes = {one.shape for gain, one in asked if gain > top - OPEN and one.suspect == change.suspect}
    return Found(
        suspect=suspect,
        shape=change.shape,
        amounts=amounts,
        stds=stds,
        usual=_usual(history, state, suspect),
        day=float(days[begin] if change.shape == CREEP else 0.5 * (days[begin] + days[begin + 1])),
        interval=(float(days[first - 1]), float(days[last])),
        alarmed=_first_seen(search, state, place, alarms),
        evidence=state.score - without.score - search.price,
        others=tuple(history.suspects[k] for k in sorted(others, key=lambda k: -others[k])),
        either=len(shapes | {change.shape}) > 1,
        like=exchanged_for(history, change, arms) if suspect.name == EXCHANGE else "",
    )


def _first_seen(search: Search, state: State, place: int, alarms: Sequence[float]) -> float:
    """The first alarm that the change can have raised; where there is none, when it was worth its price.

    Two runs have it then: of an earlier alarm it is not the cause.
    """
    history, change = search.history, state.changes[place]
    days, first = history.runs.days, change.start + FEWEST
    after = [day for day in alarms if day >= days[first - 1]]
    if after:
        return after[0]
    for stop in range(first, state.stop):
        until = tuple(one for one in state.changes if one.start <= stop - FEWEST)
        others = tuple(one for one in until if one != change)
        scores = [history.explained(one, stop, state.noise).score for one in (until, others)]
        if scores[0] - scores[1] > search.price:
            return float(days[stop - 1])
    return float(days[state.stop - 1])


def _amounts(history: History, state: State, place: int) -> tuple[np.ndarray, np.ndarray]:
    sizes = [len(history.std(one)) for one in state.changes]
    first = len(history.level) + sum(sizes[:place])
    rows = slice(first, first + sizes[place])
    inverse = np.linalg.inv(state.lower)[:, rows]
    return state.mean[rows], np.sqrt(np.sum(inverse**2, axis=0))


def _usual(history: History, state: State, suspect: Suspect) -> np.ndarray:
    """Values of which changes are shares: those before the first change, or one."""
    frame = history.learned.frame
    values = (history.level + state.mean[: len(history.level)])[: len(frame.scale)] * frame.scale
    causes = [frame.causes[k] for k in suspect.causes] if suspect.name != EXCHANGE else []
    return np.array(
        [1.0 if not one.unit else values[one.place] if one.place >= 0 else np.nan for one in causes]
    )
