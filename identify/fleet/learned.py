"""What the arms of a type teach about each other: usual values, how units differ, how runs scatter."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .runs import ArmRuns, Frame, Population, Run, population, scattered

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
