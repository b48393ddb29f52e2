"""Evidence of a log under one hypothesis, from three witnesses: shares, adequacy, and the described bodies.

Bodies of any mass leave a share of each joint's effort (`shares`), and fit as in correct logs or not
(`adequacy`). The described bodies say what is plausible in size and sign (`described_bodies`). With
probability `SPOILED`, an unlisted cause (an effect, a damaged sensor) affects a joint; its share is then
`CORRECT` under every hypothesis. So no hypothesis wins by explaining a joint slightly less badly.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..arm.rigid_regressor import rigid_regressor
from ..model import Model
from .adequacy import APART, LOST, pooled_share
from .change import Change
from .described_bodies import ANY, KINDS, Likelihood, Masses, Stated, described, likelihoods, mean_of_logs
from .samples import Sampled
from .shares import Columns, Fit

CORRECT = 0.1
"""Unpredicted share of an effort's variance that nine of ten joints in correct logs do not exceed."""
SPOILED = 0.1
"""Probability that a joint of a correct log exceeds it."""
RESOLVED = 0.001
"""Unpredicted share below which differences are not significant: friction that changes with temperature and
load causes as much in good logs."""
UNFITTED = 0.1
"""P above which nothing of this kind fits a log [-]: in correct logs of arms whose efforts are known it is at
most .09; missing physics and wrong columns exceed it."""
TOGETHER = 1.25
"""X up to which joints fit together as well as alone [-]: 1.0 to 1.1 in simulated logs and most real ones."""
WRONG_MASSES = -1.0
"""Log-likelihood of a joint for described relative to any masses, below which the masses are contradicted."""
GAINS = np.linspace(-3.0, 3.0, 13)
"""Integration points for the tolerance of a stated gain, in standard deviations."""


@dataclass(frozen=True)
class Reading:
    """A log as interpreted by one hypothesis."""

    model: Model  # model of the arm
    log: Sampled  # positions in SI units; efforts as torques from the stated gains, or in an unstated unit
    stated: bool  # whether the efforts are torques, so that all joints share the bodies

    def changed(self, change: Change) -> "Reading":
        """The log with a correction applied."""
        other = Reading(change.model(self.model), change.log(self.log), self.stated)
        if not change.of_motion:
            other.__dict__["columns"] = self.columns  # a cached property that depends only on the motion
        return other

    def without(self, times: Sequence[tuple[float, float]]) -> "Reading":
        """The log without the samples in some intervals of time [s]."""
        time = self.log.motion.time
        kept = ~np.any([(first <= time) & (time <= last) for first, last in times], axis=0)
        return replace(self, log=self.log._replace(sliding=self.log.sliding & kept[:, None]))

    @cached_property
    def columns(self) -> Columns:
        """Columns of the motion."""
        return Columns.of(self.model, self.log)

    @cached_property
    def fit(self) -> Fit:
        """Left-out errors of bodies of any mass."""
        return self.columns.fit(self.log.effort, shared=self.stated)

    @property
    def errors(self) -> np.ndarray:
        """Squared left-out errors, with shared parameters if the efforts are torques, shape (n,)."""
        return self.fit.together if self.stated else self.fit.alone

    @property
    def shares(self) -> np.ndarray:
        """Share of each effort's variance that is left, shape (n,)."""
        return self.fit.share(self.errors)

    @property
    def apart(self) -> np.ndarray:
        """X of each joint, shape (n,); 1 if the efforts have an unknown unit or are constant."""
        known = (self.fit.variance > 0.0) & (self.fit.alone > 0.0) & self.stated
        return np.sqrt(np.divide(self.errors, self.fit.alone, out=np.ones(len(known)), where=known))

    @property
    def unfitted(self) -> float:
        """P of all joints; of efforts in unknown units, the root mean square of the joints' shares."""
        if not self.stated:
            return (
                float(np.sqrt(np.mean(self.shares[self.fit.variance > 0.0])))
                if self.log.moving.any()
                else 0.0
            )
        return pooled_share(self.errors, self.fit.power, self.model.robot.revolute)

    @property
    def fits(self) -> bool:
        """Whether bodies of any mass fit as they do in correct logs."""
        return bool(self.unfitted <= UNFITTED and np.all(self.apart <= APART))

    @property
    def fits_as_well(self) -> bool:
        """Whether each joint fits, together as well as alone: then no other geometry or order is needed."""
        known = self.fit.variance > 0.0
        return bool(self.fits and np.all(self.apart <= TOGETHER) and np.all(self.shares[known] <= LOST**2))

    @property
    def misfits(self) -> list[int]:
        """Joints that fit only alone; or those that nothing explains, if these are most joints that move."""
        apart = np.flatnonzero(self.apart > APART).tolist()
        lost = np.flatnonzero((np.sqrt(self.shares) > LOST) & (self.fit.variance > 0.0)).tolist()
        return apart or (lost if 2 * len(lost) > self.log.moving.sum() and len(lost) > 1 else [])

    @cached_property
    def likelihoods(self) -> list[Likelihood]:
        """Likelihood of each joint's gain given the described masses."""
        rigid = rigid_regressor(self.model.robot.kinematics, self.log.motion)
        noise = self.fit.share(self.fit.alone)
        return likelihoods(self.model, self.log, rigid, Stated.of(self.model, self.log.motion), noise)

    @cached_property
    def _masses(self) -> list[list[float]]:
        """Log-likelihood that masses of each quality add to each joint of the log as it is."""
        return [_by_masses(likely, 1.0 if self.stated else None) for likely in self.likelihoods]

    @cached_property
    def evidence(self) -> "Evidence":
        """Evidence of the efforts."""
        return self.evidence_of(np.ones(self.model.robot.dof))

    def evidence_of(self, factor: np.ndarray, shares: np.ndarray | None = None) -> "Evidence":
        """Evidence of the efforts times factors (n,), whose shares are those of the log unless given."""
        factors = zip(self.likelihoods, self._masses, factor, strict=True)
        each = [
            _by_masses(likely, float(f)) if self.stated and f != 1.0 else plain
            for likely, plain, f in factors
        ]
        left = self.shares if shares is None else shares
        pieces = self.log.pieces
        return Evidence(by_bodies(left, pieces), np.array(each).T, pieces, described(self.model.robot))

    @property
    def quick(self) -> float:
        """Log-likelihood with bodies of any mass, by a single pass."""
        fit = self.columns.fit(self.log.effort, self.stated, alone=False, passes=1)
        shares = fit.share(fit.together if self.stated else fit.alone)
        return float(_or_spoiled(by_bodies(shares, self.log.pieces), self.log.pieces).sum())


def by_bodies(shares: np.ndarray, pieces: np.ndarray) -> np.ndarray:
    """Log-likelihood of each joint from its share and its number of independent pieces, shape (n,)."""
    return np.asarray(-0.5 * pieces * np.log(shares + RESOLVED))


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
    def as_drawn(self) -> bool:
        """Whether masses as accurate as those of a drawing contradict no joint."""
        return bool(np.all(self.by_masses[0] >= WRONG_MASSES)) or not self.drawn

    @property
    def contradicted(self) -> np.ndarray:
        """Joints whose described masses are wrong, if masses that say nothing are the most probable."""
        wrong = np.flatnonzero(self.by_masses[0] < WRONG_MASSES)
        return wrong if self.drawn and KINDS[int(np.argmax(self._kinds))] is ANY else wrong[:0]

    @property
    def agrees(self) -> bool:
        """Whether the described masses, of the most probable quality, contradict no joint."""
        return bool(np.all(self.by_masses[int(np.argmax(self._kinds))] >= WRONG_MASSES))

    @property
    def _kinds(self) -> np.ndarray:
        prior = [kind.probability if self.drawn else float(kind is ANY) for kind in KINDS]
        joints = _or_spoiled(self.by_bodies + self.by_masses, self.pieces)
        return np.asarray(np.log(np.maximum(prior, 1e-300)) + joints.sum(axis=1))


def _or_spoiled(explained: np.ndarray, pieces: np.ndarray) -> np.ndarray:
    """Log-likelihood (..., n) of joints that a hypothesis explains, or an unlisted cause."""
    spoiled = np.log(SPOILED) - 0.5 * pieces * np.log(CORRECT + RESOLVED)
    return np.asarray(np.logaddexp(np.log1p(-SPOILED) + explained, spoiled))


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
