"""Evidence: the samples and models on which a diagnosis rests, for plots, simulation and further runs."""

from dataclasses import dataclass

import numpy as np

from ...model import Model
from ...preparation.prepare import Filtering


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
