"""Strangers: outlier runs, and the arms that they may belong to.

Such a run does not affect the statements about its arm; it is described by the suspect that explains it best.
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
    """An outlier run.

    Attributes:
        run: Index among the arm's runs.
        day: Day of the run [d since 1970].
        suspect: Suspect that explains it best, as a change in this run only.
        amounts: Amounts of its causes, shape (k,).
        stds: Standard deviations of the amounts, shape (k,).
        beyond: Number of unknowns that deviate more than one in a hundred should.
        like: Another arm that the run may belong to; empty for none.
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
    """Outlier runs, of which fewer than one is expected among the allowed number of sound runs.

    Args:
        history: History of an arm.
        state: Explanation of all its runs.
        runs_allowed: Number of runs among which one false outlier is allowed.
        levels: Unknowns of the other arms of the type.
    """
    chances = 2.0 * stats.t.sf(np.sqrt(state.deviations), history.scatter.tails)
    unknowns = chances.shape[1]
    beyond = np.sum((chances < RARE) & (state.seen > 0.5), axis=1)
    count_chance = stats.binom.sf(beyond - 1, unknowns, RARE)
    odd = []
    for run in np.flatnonzero(
        np.minimum(count_chance, unknowns * np.min(chances, axis=1)) < 1.0 / runs_allowed
    ):
        evidence = history.evidence_in_run(state, int(run))
        suspect = history.suspects[int(np.argmax(evidence.gains(history.questions)))]
        like = like_arm(history, int(run), levels) if suspect.name == EXCHANGE else ""
        amounts, stds = _amounts(evidence, suspect)
        day = float(history.runs.days[run])
        odd.append(Odd(int(run), day, suspect, amounts, stds, int(beyond[run]), like))
    return odd


def like_arm(history: History, run: int, levels: Mapping[str, np.ndarray]) -> str:
    """The arm whose unknowns match a run; empty if there is none."""
    deviations = {
        arm: float(np.median(history.squared_deviations(run, level))) for arm, level in levels.items()
    }
    best = min(deviations, key=lambda arm: deviations[arm], default="")
    return best if best and deviations[best] < ODD else ""


def levels_of(learned: Learned) -> dict[str, np.ndarray]:
    """Unknowns of each arm, by the half of its runs that agree best, so that outliers do not count."""
    return {arm: _level(learned, runs) for arm, runs in learned.arms.items()}


def _level(learned: Learned, runs: ArmRuns) -> np.ndarray:
    level, _ = learned.level(runs)
    scale = np.sqrt(learned.run_variance(runs))
    for _ in range(2):
        residual = runs.right - np.einsum("rmn,rnd,d->rm", runs.normal, runs.design, level)
        solved = np.linalg.solve(runs.normal + np.diag(scale**-2.0), residual[:, :, None])[:, :, 0]
        deviations = np.median((solved / scale) ** 2, axis=1)
        level, _ = learned.level(runs[deviations <= np.median(deviations)])
    return level


def _amounts(evidence: Evidence, suspect: Suspect) -> tuple[np.ndarray, np.ndarray]:
    precision = suspect.columns @ evidence.precision @ suspect.columns.T + np.diag(suspect.std**-2.0)
    covariance = np.linalg.inv(precision)
    return covariance @ (suspect.columns @ evidence.right), np.sqrt(np.diag(covariance))


def exchanged_for(history: History, change: Change, levels: Mapping[str, np.ndarray]) -> str:
    """The arm that replaced this one, if it belongs to the fleet; empty if not."""
    runs = range(change.start, len(history.runs.days))
    matches = [like_arm(history, run, levels) for run in runs]
    arms = [arm for arm in matches if arm]
    most_frequent = max(arms, key=arms.count, default="")
    return most_frequent if 2 * arms.count(most_frequent) > len(runs) else ""
