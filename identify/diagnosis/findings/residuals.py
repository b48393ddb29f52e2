"""Residuals of a diagnosis: what remains, and its parts by cause, by quantity and by candidate."""

from dataclasses import dataclass

import numpy as np

from ...schema import Count, Probability, Real

UNCERTAIN = ""
"""Dependence of a remainder that no recorded quantity predicts well enough."""


@dataclass(frozen=True)
class Remainder:
    """Residual of one joint that no finding explains."""

    joint: int  # index of the joint, from 0
    over_noise: Real  # residual over the noise floor [-]
    probability: Probability  # probability that it is structure and not noise alone
    # Quantity on which it depends, in words, such as "position" or "velocity and position"; empty if no
    # recorded quantity predicts it well enough.
    depends_on: str


@dataclass(frozen=True, eq=False)
class Share:
    """One part of the squared residual."""

    finding: Count | None  # index of the finding, undecided ones behind the others; None for no finding
    kind: str  # quantity on which the part depends, or noise; empty for a finding
    percent: np.ndarray  # share of the squared baseline residual of each joint, shape (n,) [%]


@dataclass(frozen=True, eq=False)
class Budget:
    """The squared baseline residual of each joint divided among its causes."""

    # Residual of the baseline, fitted within its tolerances without findings, shape (n,) [N m].
    before_rms: np.ndarray
    after_rms: np.ndarray  # residual with all findings, shape (n,) [N m]
    shares: tuple[Share, ...]  # parts of the square of `before_rms`, which add up to 100 % on every joint
    # Runs that were predicted; empty where blocks of the fitted runs predict one another.
    held_out: tuple[str, ...]
