"""Likelihood of a log under one hypothesis: bodies of any mass, described masses, and unlisted causes.

Bodies explain each joint's effort up to the error of `block_prediction`. With probability `SPOILED`, an
unlisted cause (an effect, a damaged sensor) affects the joint; its unpredicted share is then `CORRECT` under
every hypothesis. So no hypothesis wins by explaining a joint slightly less badly.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..arm.rigid_regressor import rigid_regressor
from ..model import Model
from .block_prediction import BlockPrediction, Trees, trees_of
from .described_bodies import ANY, KINDS, Likelihood, Masses, Stated, described, likelihoods, mean_of_logs
from .samples import Sampled

CORRECT = 0.1
"""Unpredicted share of an effort's variance that nine of ten joints in correct logs do not exceed."""
SPOILED = 0.1
"""Probability that a joint of a correct log exceeds it."""
RESOLVED = 0.006
"""Unpredicted share below which differences are not significant: a gain error of a seventh causes as much."""
PERFECT = 0.006
"""Unpredicted share in the best logs of real arms."""
GAINS = np.linspace(-3.0, 3.0, 13)
"""Integration points for the tolerance of a stated gain, in standard deviations."""


@dataclass(frozen=True)
class Evidence:
    """Log-likelihood of each joint's effort under one hypothesis."""

    by_bodies: np.ndarray  # log-likelihood with bodies of any mass, shape (n,)
    by_masses: np.ndarray  # log-likelihood that the described masses add, for each of `KINDS`, shape (k, n)
    pieces: np.ndarray  # number of independent pieces of each effort, shape (n,)
    drawn: bool  # whether the description has real masses rather than the same number for all

    @property
    def log_likelihood(self) -> float:
        """Log-likelihood of all joints."""
        return float(np.logaddexp.reduce(self._kinds))

    @property
    def trust(self) -> np.ndarray:
        """Probability that the hypothesis, not an unlisted cause, explains each joint, shape (n,)."""
        odds = self._explained[self.kind] - self._spoiled
        return np.asarray(1.0 / (1.0 + np.exp(-np.clip(odds, -99, 99))))

    @property
    def kind(self) -> int:
        """Index of the most probable quality level of the masses."""
        return int(np.argmax(self._kinds))

    @property
    def joints(self) -> np.ndarray:
        """Log-likelihood of each joint with the most probable quality of the masses, shape (n,)."""
        return np.logaddexp(self._explained[self.kind], self._spoiled)

    @property
    def room(self) -> np.ndarray:
        """Possible gain in log-likelihood of each effort up to a perfect prediction, shape (n,)."""
        perfect = -0.5 * self.pieces * np.log(PERFECT + RESOLVED)
        return np.maximum(perfect - self.by_bodies, 0.0)

    def with_room(self, by_masses: np.ndarray) -> "Evidence":
        """Upper bound of the evidence for other signs and sizes of efforts, given `by_masses` for them."""
        return replace(self, by_bodies=self.by_bodies + self.room, by_masses=by_masses)

    @property
    def _explained(self) -> np.ndarray:
        return np.log1p(-SPOILED) + self.by_bodies + self.by_masses

    @property
    def _spoiled(self) -> np.ndarray:
        return np.log(SPOILED) - 0.5 * self.pieces * np.log(CORRECT + RESOLVED)

    @property
    def _kinds(self) -> np.ndarray:
        joints = np.logaddexp(self._explained, self._spoiled)
        prior = [kind.probability if self.drawn else float(kind is ANY) for kind in KINDS]
        return np.asarray(np.log(np.maximum(prior, 1e-300)) + joints.sum(axis=1))


@dataclass(frozen=True)
class Reading:
    """A log as interpreted by one hypothesis."""

    model: Model  # model of the arm
    log: Sampled  # positions in SI units; efforts as torques from the stated gains, or in an unstated unit
    stated: bool  # whether the efforts are torques

    @cached_property
    def _rigid(self) -> np.ndarray:
        return rigid_regressor(self.model.robot.kinematics, self.log.motion)

    @cached_property
    def _others(self) -> Stated:
        return Stated.of(self.model, self.log.motion)

    @cached_property
    def _trees(self) -> Trees:
        return trees_of(np.concatenate([self._rigid, self._others.columns], axis=2), self.log)

    def shares(
        self, method: Callable[[BlockPrediction, np.ndarray], np.ndarray], effort: np.ndarray
    ) -> np.ndarray:
        """Share of each effort (t, n) that a method of `BlockPrediction` does not explain, shape (n,)."""
        shares = np.zeros(effort.shape[1])
        for joints, prediction in self._trees:
            shares[joints] = method(prediction, effort[:, joints])
        return shares

    @cached_property
    def single(self) -> np.ndarray:
        """Unpredicted share of each effort with separate bodies of any mass for each joint, shape (n,)."""
        return self.shares(BlockPrediction.single, self.log.effort)

    @cached_property
    def coupled(self) -> np.ndarray:
        """Unpredicted share of each effort with common bodies of any mass, shape (n,)."""
        return self.shares(BlockPrediction.coupled, self.log.effort)

    @cached_property
    def likelihoods(self) -> list[Likelihood]:
        """Likelihood of each joint's gain given the described masses."""
        return likelihoods(self.model, self.log, self._rigid, self._others, self.single)

    def with_efforts(self, order: np.ndarray) -> "Reading":
        """Reading with the same motion and the efforts in another order (n,)."""
        other = Reading(self.model, self.log._replace(effort=self.log.effort[:, order]), self.stated)
        for name in ("_rigid", "_others", "_trees"):  # cached properties that depend only on the motion
            other.__dict__[name] = getattr(self, name)
        return other

    def halves(self) -> list["Reading"]:
        """Readings of the first and the second half of the log."""
        return [replace(self, log=half) for half in self.log.halves()]

    @cached_property
    def pieces(self) -> np.ndarray:
        """Number of independent pieces of each effort, shape (n,)."""
        return self.log.pieces

    def by_bodies(self, factor: np.ndarray) -> np.ndarray:
        """Log-likelihood of efforts times a factor (n,) with bodies of any mass, shape (n,)."""
        if not self.stated or np.isnan(factor).any():
            unpredicted = self.single
        elif np.all(factor == factor[0]):
            unpredicted = self.coupled
        else:
            unpredicted = self.shares(BlockPrediction.coupled, self.log.effort * factor)
        return -0.5 * self.pieces * np.log(unpredicted + RESOLVED)

    def by_masses(self, factor: np.ndarray) -> np.ndarray:
        """Log-likelihood that described masses of each quality add to it, shape (k, n)."""
        factors = [float(f) if self.stated and np.isfinite(f) else None for f in factor]
        each = [_by_masses(likely, f) for likely, f in zip(self.likelihoods, factors, strict=True)]
        return np.array(each).T

    def evidence(self, factor: np.ndarray | None = None, at_best: np.ndarray | None = None) -> Evidence:
        """Evidence of the efforts, each times a factor (n,) with its sign.

        If `at_best`, shape (k, n), is what the described masses may add at most, it is an upper bound.
        """
        factor = np.ones(self.model.robot.dof) if factor is None else factor
        if at_best is not None:
            return Evidence(self.by_bodies(factor), at_best, self.pieces, True)
        drawn = described(self.model.robot)
        return Evidence(self.by_bodies(factor), self.by_masses(factor), self.pieces, drawn)


def _by_masses(likely: Likelihood, factor: float | None) -> list[float]:
    """Log-likelihood for masses of each quality, relative to arbitrary mass, gain and sign.

    The gain is near `factor`, including its sign; without a factor, it has any size and sign.
    """
    if not likely.known:
        return [0.0] * len(KINDS)
    signs = (1.0, -1.0) if factor is None else (float(np.sign(factor)),)
    reference = mean_of_logs(np.array(list(likely.of_any.values())))
    return [
        mean_of_logs(np.array([_of_gain(likely, factor, sign, kind) for sign in signs])) - reference
        for kind in KINDS
    ]


def _of_gain(likely: Likelihood, factor: float | None, sign: float, kind: Masses) -> float:
    """Log of the mean likelihood over the gains that a mass quality allows, or over all gains."""
    if kind is ANY:
        return likely.of_any[sign]
    if factor is None:
        return mean_of_logs(likely.at(likely.gains, sign, kind))
    prior = -0.5 * GAINS**2
    prior -= np.logaddexp.reduce(prior)
    about = abs(factor) * np.exp(kind.spread * GAINS)
    return float(np.logaddexp.reduce(prior + likely.at(about, sign, kind)))
