"""Drift: when what changed on an arm, by likelihood over all causes together, run after run.

After each run, every cause is asked whether it has changed since one of the runs before, at once or creeping
since. Temperature, load and all earlier changes are unknowns beside it. An alarm is the best answer beyond
a threshold that all the questions of a year together exceed as often as the user allows.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from .history import CREEP as CREEP
from .history import SHAPES, YEAR, Change, History
from .history import STEP as STEP
from .learned import Learned
from .runs import ArmRuns

FEWEST = 2
"""Runs before and after a change: a single run out of line is a bad run."""
LEAST = 2 * FEWEST
"""Runs of an arm from which on a change is asked for."""
NORMAL_95 = 3.84
"""Twice the logarithm of a likelihood ratio within which a date lies with 95 %: chi-squared, one freedom."""
ROUNDS = 10
"""In which changes settle; usually two."""
OPEN = 3.0
"""Difference of log-likelihoods up to which another answer is not excluded: odds of 20."""


@dataclass(frozen=True)
class Found:
    """A change of an arm, all its runs considered.

    Attributes:
        cause: Place among the frame's causes.
        shape: `STEP` or `CREEP`.
        amount: By now, in the cause's unit.
        std: Standard deviation of the amount.
        day: When it changed, or began to [d since 1970].
        interval: In which that lies with 95 % [d].
        alarmed: When it was first seen [d].
        deviations: Amount over its standard deviation.
        usual: Value before the first change; NaN where there is none.
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
    """

    found: tuple[Found, ...]
    alarms: tuple[float, ...]
    threshold: float


def drift(learned: Learned, runs: ArmRuns, alarms_per_year: float) -> ArmDrift:
    """Changes of one arm; as many false alarms a year are allowed."""
    history, changes, alarms = History(learned, runs), list[Change](), list[tuple[float, int]]()
    threshold = threshold_of(learned, runs, alarms_per_year)
    for stop in range(LEAST, len(runs.runs) + 1):
        changes = _again(history, changes, stop)
        best = history.best(changes, stop, windows(stop))
        while best.deviations > threshold and len(changes) < stop // FEWEST:
            alarms.append((float(runs.days[stop - 1]), len(changes)))
            changes = _again(history, [*changes, best.change], stop)
            best = history.best(changes, stop, windows(stop))
    whole = len(runs.runs)
    changes = _settled(history, changes, whole)
    first = {place: day for day, place in reversed(alarms)}
    found = [_found(history, changes, place, first[place], whole) for place in range(len(changes))]
    ordered = tuple(sorted((one for one in found if one.deviations > threshold), key=lambda one: one.day))
    return ArmDrift(ordered, tuple(day for day, _ in alarms), threshold)


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


def _settled(history: History, changes: list[Change], stop: int) -> list[Change]:
    """The same until none moves any more, begun at any run: each makes the runs more probable."""
    for _ in range(ROUNDS):
        before, changes = changes, _again(history, changes, stop, _starts(stop))
        if changes == before:
            break
    return changes


def _starts(stop: int) -> list[int]:
    """First runs after a change that are possible."""
    return list(range(FEWEST, stop - FEWEST + 1))


def _again(history: History, changes: list[Change], stop: int, starts: Sequence[int] = ()) -> list[Change]:
    """Each change in turn as the runs so far show it, the others held."""
    for place, change in enumerate(changes):
        others = changes[:place] + changes[place + 1 :]
        best = history.best(others, stop, sorted({*(starts or windows(stop)), change.start}))
        changes = [*changes[:place], best.change, *changes[place + 1 :]]
    return changes


def _found(history: History, changes: list[Change], place: int, alarmed: float, stop: int) -> Found:
    """A change with its date, its interval and what it might be instead, the others held."""
    others = changes[:place] + changes[place + 1 :]
    starts = _starts(stop)
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
        usual=_usual(history, cause, changes),
        others=tuple(int(k) for k in np.argsort(-by_cause) if k != cause and by_cause[k] > top - OPEN),
        either=bool(np.min(by_shape) > top - OPEN),
    )


def _usual(history: History, cause: int, changes: list[Change]) -> float:
    """The value of which a change is a share: that before the first change, or one."""
    frame = history.learned.frame
    one = frame.causes[cause]
    if not one.unit:
        return 1.0
    if one.place < 0:
        return float("nan")
    return float((history.before(changes) * frame.scale)[one.place])
