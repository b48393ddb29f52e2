"""What arms of a type teach about each other: usual values, how units differ, how runs scatter, residuals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy import stats

from ..errors import RecordingError
from ..fit.estimators.compressed import Compressed
from .runs import ArmRuns, Frame, Population, Run, design_of, population, scattered

PASSES = 3
"""Of scatter, units and the point of linearisation, each from the others: the third moves none by a tenth."""
LEAST_SCATTER = 1e-3
"""Scatter from run to run, over the spread between units, below which none is believed [-]."""
FIRST_SCATTER = 0.1
"""The same to begin with."""
MOST = 1.0
"""Logarithm of a drive gain over the nominal one, at most: data sheets are not wrong by a factor of e."""
ALIKE = 10
"""Pairs of runs for which scatter of other joints counts: by a few pairs a joint may seem to have none."""
HALVINGS = 20
"""Of the logarithm of a scatter's bounds: it is then known to far below a per cent."""
ROBUST = 1.4826
"""Standard deviation over the median of absolute values, of normal numbers."""


@dataclass(frozen=True, eq=False)
class Learned:
    """A type of arm with all its runs.

    Attributes:
        frame: Causes and units.
        arms: Runs of each, each linearised about its own values.
        units: Mean and spread of the unknowns between units, temperature's included, shape (d,).
        trust: Variance that runs of one arm have, over what their residuals say, at most one: what a model
            leaves is the same in each run of one motion, and so no scatter [-].
        scatter: Variance of each scattering cause from run to run, over `Frame.sizes` squared, shape (s,).
        freedom: Pairs of runs from which that was estimated.
    """

    frame: Frame
    arms: Mapping[str, ArmRuns]
    units: Population
    trust: float
    scatter: np.ndarray
    freedom: int

    @property
    def scattering(self) -> list[int]:
        """Causes that scatter."""
        return [place for place, one in enumerate(self.frame.causes) if one.scatters]

    def sizes(self, runs: ArmRuns) -> np.ndarray:
        """`Frame.sizes` of an arm's scattering causes, shape (s,)."""
        return self.frame.sizes(runs.about)[self.scattering]

    def run_variance(self, runs: ArmRuns) -> np.ndarray:
        """Variance of each unknown of an arm from run to run, in the frame's units, shape (m,)."""
        frame, joints = self.frame, self.frame.kind.model.robot.dof
        found = (LEAST_SCATTER**2) * self.units.variance[: len(frame.scale)]
        for k, variance, size in zip(self.scattering, self.scatter, self.sizes(runs), strict=True):
            one, gains = frame.causes[k], len(frame.scale) - joints
            place = gains + one.joint if one.effect == "drive_gain" else one.place
            if place >= 0:
                found[place] = max(found[place], variance * (size * frame.directions[k, place]) ** 2)
        return found

    @property
    def spread(self) -> np.ndarray:
        """Of each scattering cause's amount between units, shape (s,): what lies a deviation off."""
        directions = self.frame.directions[self.scattering]
        return 1.0 / np.sqrt(np.sum(directions**2 / self.units.variance[: directions.shape[1]], axis=1))

    def says(self, runs: ArmRuns) -> tuple[np.ndarray, np.ndarray]:
        """What runs say of the arm's usual unknowns, their scatter allowed for, shapes (r, m, m), (r, m)."""
        directions, variance = self.frame.directions[self.scattering], self.scatter * self.sizes(runs) ** 2
        return scattered(runs.normal / self.trust, runs.right / self.trust, directions, variance)

    def level(self, runs: ArmRuns) -> tuple[np.ndarray, np.ndarray]:
        """Mean and covariance of the arm's unknowns by these runs."""
        return self.units.posterior(*summed(runs, *self.says(runs)))

    def deviations(self, runs: ArmRuns, level: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Amount of each scattering cause in each run over the arm's level (d,), and the noise's covariance.

        With the spread between units as prior; shapes (r, s), (r, s, s).
        """
        directions = self.frame.directions[self.scattering]
        left = runs.right - np.einsum("rmn,rnd,d->rm", runs.normal, runs.design, level)
        precision = directions @ runs.normal @ directions.T / self.trust
        covariance = np.linalg.inv(precision + np.diag(self.spread**-2.0))
        amounts = np.einsum("rst,rt->rs", covariance, left @ directions.T) / self.trust
        return amounts, covariance @ precision @ covariance


def learned(frame: Frame, arms: Mapping[str, Sequence[Run]]) -> Learned:
    """Usual values, spread and scatter of the arms of one type."""
    joints = frame.kind.model.robot.dof
    values, gain = frame.before.mean[:-joints], frame.kind.gain
    runs = {name: ArmRuns.of(frame, own, values, gain) for name, own in arms.items()}
    scatters = sum(one.scatters for one in frame.causes)
    found = Learned(frame, runs, frame.start, 1.0, np.ones(scatters), 0)
    sizes = frame.sizes(frame.before.mean / frame.scale)[found.scattering]
    found = replace(found, scatter=(FIRST_SCATTER * found.spread / sizes) ** 2)
    for _ in range(PASSES):
        sums = [summed(own, *found.says(own)) for own in found.arms.values()]
        normals, rights = (np.stack(part) for part in zip(*sums, strict=True))
        units = population(normals, rights, frame.start)
        found = _scatter(replace(found, units=units))
        found = replace(found, arms={name: _about(found, own) for name, own in found.arms.items()})
    return found


def summed(runs: ArmRuns, normal: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What all runs together say of the arm's unknowns, (d, d) and (d,)."""
    turned = np.swapaxes(runs.design, 1, 2)
    return np.sum(turned @ (normal @ runs.design), axis=0), np.einsum("rdm,rm->d", turned, right)


def _about(found: Learned, runs: ArmRuns) -> ArmRuns:
    """The runs linearised about the values that they say."""
    frame, joints = found.frame, found.frame.kind.model.robot.dof
    own = found.level(runs)[0][: len(frame.scale)] * frame.scale
    gain = frame.kind.gain * np.exp(np.clip(own[-joints:], -MOST, MOST))
    return ArmRuns.of(frame, runs.runs, own[:-joints], gain)


def _scatter(found: Learned) -> Learned:
    """Scatter by differences of successive runs, which hardly see a slow change, and medians, nor a step."""
    found = replace(found, trust=1.0)
    differences, expected = [], []
    for runs in found.arms.values():
        if np.count_nonzero(~runs.loose) < 2:
            continue
        amounts, covariance = found.deviations(runs[~runs.loose], found.level(runs)[0])
        sizes = found.sizes(runs)
        said = np.diagonal(covariance, axis1=1, axis2=2) / sizes**2
        differences.append(np.diff(amounts / sizes, axis=0))
        expected.append(said[1:] + said[:-1])
    if not differences:
        return found
    every, usual = np.concatenate(differences), np.concatenate(expected)
    # Rounding leaves variances below zero where the numbers of a run are damaged: it says nothing of scatter.
    sound = np.all(usual > 0.0, axis=1)
    if not sound.any():
        return found
    every, usual = every[sound], usual[sound]
    seen = _robust(every / np.sqrt(usual))
    trust = float(np.clip(np.median(seen), LEAST_SCATTER, 1.0))
    sizes = found.frame.sizes(found.units.mean[: len(found.frame.scale)])[found.scattering]
    least = (LEAST_SCATTER * found.spread / sizes) ** 2
    share = _excess(every, trust * usual, least) / least
    return replace(found, trust=trust, scatter=least * _alike(found, share, len(every)), freedom=len(every))


def _alike(found: Learned, share: np.ndarray, pairs: int) -> np.ndarray:
    """Scatter (s,), over the spread between units, with that of the same effect on other joints."""
    effects = np.array([found.frame.causes[place].effect for place in found.scattering])
    usual = np.array([np.median(share[effects == one]) for one in effects])
    return (pairs * share + ALIKE * usual) / (pairs + ALIKE)


def _robust(values: np.ndarray) -> np.ndarray:
    """Variance of each column by the median of absolute values."""
    return np.square(ROBUST * np.median(np.abs(values), axis=0))


def _excess(differences: np.ndarray, said: np.ndarray, least: np.ndarray) -> np.ndarray:
    """Variance that both runs of a pair have beyond what is said of their difference, shape (s,)."""
    low, high = least, np.maximum(_robust(differences), 2.0 * least)
    for _ in range(HALVINGS):
        middle = np.sqrt(low * high)
        more = _robust(differences / np.sqrt(said + 2.0 * middle)) > 1.0
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return low


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
