"""Residuals of a diagnosis: what remains, and its parts by cause, by quantity and by candidate."""

from dataclasses import dataclass

import numpy as np

from ...schema import Count, EffectName, Probability, Real

UNCERTAIN = ""
"""Dependence of a remainder that no recorded quantity predicts well enough."""


@dataclass(frozen=True)
class Remainder:
    """Residual of one joint that no finding explains.

    Attributes:
        joint: Index of the joint, from 0.
        over_noise: Residual over the noise floor [-].
        probability: Probability that it is structure and not noise alone.
        depends_on: Quantity on which it depends, in words, such as "position" or "velocity and position";
            empty if no recorded quantity predicts it well enough.
    """

    joint: int
    over_noise: Real
    probability: Probability
    depends_on: str


@dataclass(frozen=True, eq=False)
class Share:
    """One part of the squared residual.

    Attributes:
        finding: Index of the finding, undecided ones behind the others; None for no finding.
        kind: Quantity on which the part depends, or noise; empty for a finding.
        percent: Share of the squared baseline residual of each joint, shape (n,) [%].
    """

    finding: Count | None
    kind: str
    percent: np.ndarray


@dataclass(frozen=True, eq=False)
class Budget:
    """The squared baseline residual of each joint divided among its causes.

    Attributes:
        before_rms: Residual of the baseline, fitted within its tolerances without findings, shape (n,) [N m].
        after_rms: Residual with all findings, shape (n,) [N m].
        shares: Parts of the square of `before_rms`, which add up to 100 % on every joint.
        held_out: Runs that were predicted; empty where blocks of the fitted runs predict one another.
    """

    before_rms: np.ndarray
    after_rms: np.ndarray
    shares: tuple[Share, ...]
    held_out: tuple[str, ...]


@dataclass(frozen=True)
class Change:
    """Change of the residual by one candidate alone.

    Attributes:
        effect: Name in the vocabulary.
        joints: Where it acts, from 0.
        joint: Joint that improves most, from 0.
        squared_error_percent: Change of the squared prediction error of that joint [%]; negative is better.
        std_percent: Standard deviation of that change over blocks [%].
        gain: Logarithm of the Bayes factor for the candidate.
        which: Detail, in words, that distinguishes it from other candidates with its effect and joints.
    """

    effect: EffectName
    joints: tuple[int, ...]
    joint: int
    squared_error_percent: Real
    std_percent: Real
    gain: Real
    which: str = ""


@dataclass(frozen=True)
class Located:
    """One row of the table of residuals by quantity.

    Attributes:
        joint: Index of the joint, from 0.
        depends_on: A key of `DEPENDENCES`, an effect without a family, or the dependence of a remainder.
        share: Share of the squared baseline residual of the joint, in held-out runs if there are any [-].
        probability: Probability that the torque depends on the quantity; None for noise, for parts without a
            dependence, and if the explained part may be zero.
        finding: Index of the finding that explains it, undecided ones behind the others; None without any.
    """

    joint: int
    depends_on: str
    share: Real
    probability: float | None
    finding: int | None


@dataclass(frozen=True)
class Hinted:
    """An effect that held-out runs show and fitted runs do not contradict; naming it requires fitting them.

    Attributes:
        effect: Name in the vocabulary.
        joint: Index of the joint that shows it best in the held-out runs, from 0; in files from 1.
        depends_on: Quantity on which it depends; see `Located`.
        gain: Log likelihood ratio of the fitted blocks with and without it.
        gain_held_out: Log likelihood ratio of the held-out runs, predicted by the fitted blocks.
        change: Relative change of the joint's squared residual in the held-out runs [-]; negative is better.
        std: Standard deviation of that change over blocks [-].
    """

    effect: str
    joint: int
    depends_on: str
    gain: Real
    gain_held_out: Real
    change: Real
    std: Real
