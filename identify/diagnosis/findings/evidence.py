"""Evidence: the samples and models on which a diagnosis rests, and what remains of its residual by cause."""

from dataclasses import dataclass

import numpy as np

from ...model import Model
from ...preparation.prepare import Filtering
from ...schema import Count, Probability, Real


@dataclass(frozen=True, eq=False)
class Trace:
    """One run at the sampling rate of the comparison."""

    name: str  # name of the run
    role: str  # "validate" for a held-out run
    time: np.ndarray  # shape (r,) [s]
    position: np.ndarray  # shape (r, n) [rad]
    velocity: np.ndarray  # shape (r, n) [rad/s]
    acceleration: np.ndarray  # shape (r, n) [rad/s^2]
    load: np.ndarray  # nominal torque that the gears transmit, shape (r, n) [N m]
    temperature: np.ndarray  # shape (r, n) [degC]; NaN where it was not measured
    motor_angle: np.ndarray  # angle of each motor's shaft, shape (r, n) [rad]
    measured: np.ndarray  # torque by currents and nominal gains, shape (r, n) [N m]
    before: np.ndarray  # residual without findings, shape (r, n) [N m]
    after: np.ndarray  # residual with all findings, shape (r, n) [N m]
    explained: np.ndarray  # torque of each finding, shape (f, r, n) [N m]
    weight: np.ndarray  # 0 where a joint sticks, else 1, shape (r, n)


@dataclass(frozen=True, eq=False)
class Evidence:
    """Models without and with the findings, and the traces of all runs."""

    model: Model  # nominal, with the payloads of the runs
    before: np.ndarray  # parameters fitted within their tolerances without findings, shape (p,)
    after: np.ndarray  # parameters fitted within their tolerances together with the findings, shape (p,)
    gain_before: np.ndarray  # drive gains without findings, shape (n,) [N m/A]; 1 where torque was recorded
    gain_after: np.ndarray  # drive gains fitted within their tolerances, shape (n,) [N m/A]
    noise: np.ndarray  # noise floor of each joint's torque behind the filter, shape (n,) [N m]
    traces: tuple[Trace, ...]  # held-out runs first
    filtering: Filtering = Filtering()  # noqa: RUF009  # filters of all runs
    peak: np.ndarray | None = None  # largest torque of each motor in the fitted runs, shape (n,) [N m]


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
