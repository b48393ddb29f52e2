"""Expected: how large an arm's residual usually is over a run, and from where on it is an alarm."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import stats

from ..errors import RecordingError
from ..fit.estimators.compressed import Compressed
from .learned import Learned
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
        mean: Mean of the logarithm of a run's residual by the values that the others show, shape (n,).
        scatter: Deviation of the logarithm of the residual from run to run, shape (n,) [-].
        freedom: Pairs of runs, of all arms of the type, from which that is known.
    """

    runs: ArmRuns
    level: np.ndarray
    mean: np.ndarray
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
        seen = _logarithms(learned, own)
        every = [_logarithms(learned, arm[~arm.loose]) for arm in learned.arms.values()]
        pairs = np.concatenate([np.diff(one, axis=0) for one in every])
        scatter = np.sqrt(0.5 * np.mean(pairs**2, axis=0))
        return cls(own, learned.level(own)[0], np.mean(seen, axis=0), scatter, len(pairs))

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

        Friction that scatters adds to the square of the residual, whose logarithm so has a longer upper tail
        than a normal number: it is taken for Laplace's, or Student's where fewer pairs make that longer.
        """
        count, joints = len(self.runs.runs), len(self.mean)
        share = min(alarms_per_year * self.seconds / (SECONDS_A_YEAR * joints), 1.0)
        deviations = float(
            max(stats.t.isf(share, self.freedom), stats.laplace.isf(share, scale=np.sqrt(0.5)))
        )
        deviations *= float(np.sqrt(1.0 + 1.0 / count))
        return Limits(np.exp(self.mean), np.exp(self.mean + deviations * self.scatter))


def _logarithms(learned: Learned, runs: ArmRuns) -> np.ndarray:
    """Of the residual of each run by the values that the arm's other runs show, shape (r, n)."""
    normal, right = learned.says(runs)
    turned, units = np.swapaxes(runs.design, 1, 2), learned.units
    normals, rights = turned @ (normal @ runs.design), np.einsum("rdm,rm->rd", turned, right)
    precision = normals.sum(axis=0) - normals + np.diag(1.0 / units.variance)
    sides = rights.sum(axis=0) - rights + units.mean / units.variance
    levels = np.linalg.solve(precision, sides[:, :, None])[:, :, 0]
    triples = zip(runs.runs, runs.design, levels, strict=True)
    found = [_residual(runs.frame, run, design @ level) for run, design, level in triples]
    return np.log(found).reshape(len(found), runs.frame.kind.model.robot.dof)


def _residual(frame: Frame, run: Run, unknowns: np.ndarray) -> np.ndarray:
    """Of a run by unknowns in the frame's units, shape (n,) [N m]."""
    joints, values = frame.kind.model.robot.dof, unknowns * frame.scale
    compressed = Compressed(tuple(run.summary.factors), run.summary.counts)
    return compressed.residual_std(values[:-joints], frame.kind.gain * np.exp(values[-joints:]))
