"""How likely a log is as it is read: bodies of any mass, described masses, and something that is not listed.

Each joint's effort is explained by the bodies to what `block_prediction` leaves, or, with probability
`SPOILED`, by something that no hypothesis lists (an effect, a damaged sensor): then no more than `CORRECT` of
it is predicted, whatever the hypothesis. So no hypothesis wins by explaining a joint a little less badly.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..arm.rigid_regressor import rigid_regressor
from ..model import Model
from .block_prediction import ArmPrediction
from .described_bodies import (
    ANY,
    KINDS,
    Likelihood,
    Masses,
    Stated,
    described,
    likelihoods,
    mean_of_logs,
)
from .samples import Sampled

CORRECT = 0.1
"""Share of an effort's variance that right logs of real arms leave unpredicted in nine joints of ten."""
SPOILED = 0.1
"""Probability that a joint of a right log leaves more: the tenth."""
RESOLVED = 0.006
"""Share of a variance below which less says nothing more: a gain off by a seventh leaves as much."""
PERFECT = 0.006
"""Share of a variance that the best logs of real arms leave."""
GAINS = np.linspace(-3.0, 3.0, 13)
"""Gains over which the spread of a stated gain is integrated, in its standard deviations."""


@dataclass(frozen=True)
class Evidence:
    """Log-likelihood of each joint's effort under one hypothesis.

    Attributes:
        by_bodies: By bodies of any mass, shape (n,).
        by_masses: What masses of each of `KINDS` add to that, shape (k, n).
        pieces: Independent pieces of each effort, shape (n,).
        drawn: Whether the masses of the description are not one number for all.
    """

    by_bodies: np.ndarray
    by_masses: np.ndarray
    pieces: np.ndarray
    drawn: bool

    @property
    def log_likelihood(self) -> float:
        """Of all joints."""
        return float(np.logaddexp.reduce(self._kinds))

    @property
    def trust(self) -> np.ndarray:
        """Probability that each joint is explained by the hypothesis and not spoiled, shape (n,)."""
        odds = self._explained[self.kind] - self._spoiled
        return np.asarray(1.0 / (1.0 + np.exp(-np.clip(odds, -99, 99))))

    @property
    def kind(self) -> int:
        """Place of the likeliest kind of masses."""
        return int(np.argmax(self._kinds))

    @property
    def joints(self) -> np.ndarray:
        """Log-likelihood of each joint by the likelier kind of masses, shape (n,)."""
        return np.logaddexp(self._explained[self.kind], self._spoiled)

    @property
    def left(self) -> np.ndarray:
        """Share of each effort's variance that bodies of any mass leave, shape (n,)."""
        return np.asarray(np.exp(-2.0 * self.by_bodies / self.pieces) - RESOLVED)

    @property
    def room(self) -> np.ndarray:
        """By how much the bodies of a perfect reading would explain each effort better, shape (n,)."""
        perfect = -0.5 * self.pieces * np.log(PERFECT + RESOLVED)
        return np.maximum(perfect - self.by_bodies, 0.0)

    def with_room(self, by_masses: np.ndarray) -> "Evidence":
        """The most that other signs and sizes of the efforts could reach, by what the masses say of them."""
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
    """A log as one hypothesis reads it.

    Attributes:
        model: The arm.
        log: Positions in SI, efforts as torques by the gains stated, or in a unit that nobody stated.
        stated: Whether the efforts are torques.
    """

    model: Model
    log: Sampled
    stated: bool

    @cached_property
    def _rigid(self) -> np.ndarray:
        return rigid_regressor(self.model.robot.kinematics, self.log.motion)

    @cached_property
    def _others(self) -> Stated:
        return Stated.of(self.model, self.log.motion)

    @cached_property
    def prediction(self) -> ArmPrediction:
        """Columns of this motion."""
        return ArmPrediction.of(np.concatenate([self._rigid, self._others.columns], axis=2), self.log)

    @cached_property
    def single(self) -> np.ndarray:
        """Share of each effort that bodies of any mass of its own leave, shape (n,)."""
        return self.prediction.single(self.log.effort)

    @cached_property
    def coupled(self) -> np.ndarray:
        """Share of each effort that one set of bodies for all joints leaves, shape (n,)."""
        return self.prediction.coupled(self.log.effort)

    @cached_property
    def likelihoods(self) -> list[Likelihood]:
        """What the described masses say of each joint's gain."""
        return likelihoods(self.model, self.log, self._rigid, self._others, self.single)

    def with_efforts(self, order: np.ndarray) -> "Reading":
        """The same motion with the efforts in another order (n,)."""
        other = Reading(self.model, self.log._replace(effort=self.log.effort[:, order]), self.stated)
        for name in ("_rigid", "_others", "prediction"):  # cached: they are of the motion alone
            other.__dict__[name] = getattr(self, name)
        return other

    def halves(self) -> list["Reading"]:
        """The first half of the log and the second."""
        return [replace(self, log=half) for half in self.log.halves()]

    @cached_property
    def pieces(self) -> np.ndarray:
        """Independent pieces of each effort, shape (n,)."""
        return self.log.pieces

    def by_bodies(self, factor: np.ndarray) -> np.ndarray:
        """Log-likelihood of efforts, each times a factor (n,), by bodies of any mass, shape (n,)."""
        if not self.stated or np.isnan(factor).any():
            left = self.single
        elif np.all(factor == factor[0]):
            left = self.coupled
        else:
            left = self.prediction.coupled(self.log.effort * factor)
        return -0.5 * self.pieces * np.log(left + RESOLVED)

    def by_masses(self, factor: np.ndarray) -> np.ndarray:
        """What masses of each kind add to that, shape (k, n)."""
        factors = [float(f) if self.stated and np.isfinite(f) else None for f in factor]
        each = [_by_masses(likely, f) for likely, f in zip(self.likelihoods, factors, strict=True)]
        return np.array(each).T

    def at_best(self, by_masses: np.ndarray, factor: np.ndarray | None) -> Evidence:
        """The evidence of efforts times a factor (n,) if the masses added `by_masses`, shape (k, n)."""
        factor = np.ones(self.model.robot.dof) if factor is None else factor
        return Evidence(self.by_bodies(factor), by_masses, self.pieces, True)

    def evidence(self, factor: np.ndarray | None = None) -> Evidence:
        """Evidence of the efforts, each times a factor (n,) with its sign."""
        factor = np.ones(self.model.robot.dof) if factor is None else factor
        drawn = described(self.model.robot)
        return Evidence(self.by_bodies(factor), self.by_masses(factor), self.pieces, drawn)


def _by_masses(likely: Likelihood, factor: float | None) -> list[float]:
    """Log-likelihood by masses of each kind, over that of any mass, gain and sign.

    The gain is about `factor`, with its sign, or of any size and sign.
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
    """Mean over the gains that a kind of masses allows, or over all."""
    if kind is ANY:
        return likely.of_any[sign]
    if factor is None:
        return mean_of_logs(likely.at(likely.gains, sign, kind))
    prior = -0.5 * GAINS**2
    prior -= np.logaddexp.reduce(prior)
    about = abs(factor) * np.exp(kind.spread * GAINS)
    return float(np.logaddexp.reduce(prior + likely.at(about, sign, kind)))
