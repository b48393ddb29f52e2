"""Expected: how large an arm's residual usually is over a run, and from where on it is an alarm."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import stats

from ..errors import RecordingError
from ..fit.estimators.compressed import Compressed
from .learned import Learned, robust
from .runs import ArmRuns, Frame, Run, design_of

FEWEST = 3
"""Runs from which a residual's usual size is told: two leave no more than its order of magnitude."""
SECONDS_A_YEAR = 365.25 * 86400.0


class Limits(NamedTuple):
    """Residual of each joint, shapes (n,) [N m]: what is usual, and above what it is an alarm."""

    usual: np.ndarray
    alarm: np.ndarray


@dataclass(frozen=True, eq=False)
class Expected:
    """An arm as its runs show it.

    Attributes:
        runs: Those that count: without a body that is not known.
        level: The arm's unknowns by them, shape (d,).
        scatter: Deviation of the logarithm of the residual from run to run, shape (n,) [-].
        freedom: Pairs of runs, of all arms of the type, from which that is known.
    """

    runs: ArmRuns
    level: np.ndarray
    scatter: np.ndarray
    freedom: int

    @classmethod
    def of(cls, learned: Learned, runs: ArmRuns) -> "Expected":
        """By an arm's runs, and how residuals of all arms of the type differ between successive runs.

        Raises:
            RecordingError: Fewer than `FEWEST`.
        """
        own = runs[~runs.loose]
        if len(own.runs) < FEWEST:
            raise RecordingError(
                f"{len(own.runs)} runs without an unknown body since the last change: fewer than {FEWEST} do "
                "not show how large the residual usually is"
            )
        every = [arm[~arm.loose] for arm in learned.arms.values()]
        pairs = np.concatenate([np.diff(_logarithms(arm, learned.level(arm)[0]), axis=0) for arm in every])
        return cls(own, learned.level(own)[0], np.sqrt(0.5 * robust(pairs)), len(pairs))

    @property
    def seconds(self) -> float:
        """Usual duration of a run [s]: over as long a time a residual is comparable with theirs."""
        return float(np.median([run.summary.seconds for run in self.runs.runs]))

    def residual(self, run: Run) -> np.ndarray:
        """Root mean square of what this arm's values leave of a run, shape (n,) [N m]."""
        design = design_of(self.runs.frame, [*self.runs.runs, run])[-1]
        return _residual(self.runs.frame, run, design @ self.level)

    def limits(self, alarms_per_year: float) -> Limits:
        """What of all joints together a sound arm that always moves exceeds as often a year.

        The logarithm of a run's residual is taken for normal, with Student's distribution for its deviation.
        """
        seen = _logarithms(self.runs, self.level)
        count, joints = seen.shape
        share = min(alarms_per_year * self.seconds / (SECONDS_A_YEAR * joints), 1.0)
        deviations = float(stats.t.isf(share, self.freedom)) * np.sqrt(1.0 + 1.0 / count)
        mean = np.mean(seen, axis=0)
        return Limits(np.exp(mean), np.exp(mean + deviations * self.scatter))


def _logarithms(runs: ArmRuns, level: np.ndarray) -> np.ndarray:
    """Of the residual of each run, shape (r, n)."""
    pairs = zip(runs.runs, runs.design, strict=True)
    found = np.array([_residual(runs.frame, run, design @ level) for run, design in pairs])
    return np.log(found).reshape(len(runs.runs), runs.frame.kind.model.robot.dof)


def _residual(frame: Frame, run: Run, unknowns: np.ndarray) -> np.ndarray:
    """Of a run by unknowns in the frame's units, shape (n,) [N m]."""
    joints, values = frame.kind.model.robot.dof, unknowns * frame.scale
    compressed = Compressed(tuple(run.summary.factors), run.summary.counts)
    return compressed.residual_std(values[:-joints], frame.kind.gain * np.exp(values[-joints:]))
