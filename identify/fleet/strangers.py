"""Strangers: single runs out of line, and whose runs they are.

Such a run changes nothing of what is said of its arm; it is named by the one suspect that explains it best.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy import stats

from .evidence import Evidence
from .history import Change, History, State
from .learned import Learned
from .runs import ArmRuns
from .scatter import ODD, RARE
from .suspects import EXCHANGE, Suspect


class Odd(NamedTuple):
    """A run out of line.

    Attributes:
        run: Place among the arm's runs.
        day: When it was [d since 1970].
        suspect: What explains it best, in this run only.
        amounts: Of its causes, shape (k,), and
        stds: their standard deviations.
        beyond: Unknowns in which it is farther off than one in a hundred is.
        like: Another arm whose run it may be; empty for none.
    """

    run: int
    day: float
    suspect: Suspect
    amounts: np.ndarray
    stds: np.ndarray
    beyond: int
    like: str


def odd_runs(
    history: History, state: State, runs_allowed: float, levels: Mapping[str, np.ndarray]
) -> list[Odd]:
    """Runs that of so many sound ones less than one would be.

    Args:
        history: Of an arm.
        state: All its runs explained.
        runs_allowed: Among so many runs one is named by chance.
        levels: Unknowns of the other arms of the type.
    """
    chances = 2.0 * stats.t.sf(np.sqrt(state.deviations), history.scatter.tails)
    unknowns = chances.shape[1]
    beyond = np.sum((chances < RARE) & (state.seen > 0.5), axis=1)
    many = stats.binom.sf(beyond - 1, unknowns, RARE)
    found = []
    for run in np.flatnonzero(np.minimum(many, unknowns * np.min(chances, axis=1)) < 1.0 / runs_allowed):
        evidence = history.asked_of(state, int(run))
        suspect = history.suspects[int(np.argmax(evidence.gains(history.questions)))]
        like = like_arm(history, int(run), levels) if suspect.name == EXCHANGE else ""
        amounts, stds = _amounts(evidence, suspect)
        day = float(history.runs.days[run])
        found.append(Odd(int(run), day, suspect, amounts, stds, int(beyond[run]), like))
    return found


def like_arm(history: History, run: int, levels: Mapping[str, np.ndarray]) -> str:
    """The arm by whose unknowns a run is a usual one; empty if there is none."""
    off = {arm: float(np.median(history.off(run, level))) for arm, level in levels.items()}
    best = min(off, key=lambda arm: off[arm], default="")
    return best if best and off[best] < ODD else ""


def levels_of(learned: Learned) -> dict[str, np.ndarray]:
    """Unknowns of each arm by the runs that are most alike, so that a stranger among them does not count."""
    return {arm: _level(learned, runs) for arm, runs in learned.arms.items()}


def _level(learned: Learned, runs: ArmRuns) -> np.ndarray:
    level, _ = learned.level(runs)
    scale = np.sqrt(learned.run_variance(runs))
    for _ in range(2):
        left = runs.right - np.einsum("rmn,rnd,d->rm", runs.normal, runs.design, level)
        solved = np.linalg.solve(runs.normal + np.diag(scale**-2.0), left[:, :, None])[:, :, 0]
        off = np.median((solved / scale) ** 2, axis=1)
        level, _ = learned.level(runs[off <= np.median(off)])
    return level


def _amounts(evidence: Evidence, suspect: Suspect) -> tuple[np.ndarray, np.ndarray]:
    precision = suspect.columns @ evidence.precision @ suspect.columns.T + np.diag(suspect.std**-2.0)
    covariance = np.linalg.inv(precision)
    return covariance @ (suspect.columns @ evidence.right), np.sqrt(np.diag(covariance))


def exchanged_for(history: History, change: Change, levels: Mapping[str, np.ndarray]) -> str:
    """The arm that was put in place of this one, if it is one of the fleet."""
    runs = range(change.start, len(history.runs.days))
    likes = [like_arm(history, run, levels) for run in runs]
    named = [one for one in likes if one]
    most = max(named, key=named.count, default="")
    return most if 2 * named.count(most) > len(runs) else ""
