"""Trace: what remained of one run's torque before and after, beside what the arm did meanwhile."""

from dataclasses import dataclass

import numpy as np

from ...model import Model
from ...preparation.prepare import Filtering


@dataclass(frozen=True, eq=False)
class Trace:
    """One run, thinned out as it was compared.

    Attributes:
        name: Of the run.
        role: What it was for; "validate" was predicted only.
        time: Shape (r,) [s].
        position: Shape (r, n) [rad].
        velocity: Shape (r, n) [rad/s].
        acceleration: Shape (r, n) [rad/s^2].
        load: Torque that the gears transmit, nominal, shape (r, n) [N m].
        temperature: Shape (r, n) [degC]; NaN where it was not measured.
        motor_angle: Angle of each motor's shaft, shape (r, n) [rad].
        measured: Torque by currents and nominal gains, shape (r, n) [N m].
        before: What the model leaves of it, nominal but for friction and offsets, shape (r, n) [N m].
        after: What is left with everything that was found, shape (r, n) [N m].
        explained: Torque of each finding, shape (f, r, n) [N m].
        weight: 0 where a joint sticks, else 1, shape (r, n).
    """

    name: str
    role: str
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    load: np.ndarray
    temperature: np.ndarray
    motor_angle: np.ndarray
    measured: np.ndarray
    before: np.ndarray
    after: np.ndarray
    explained: np.ndarray
    weight: np.ndarray


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a diagnosis rests on, for those who draw it, simulate it or build on it.

    Attributes:
        model: Nominal, with the payloads of the runs.
        before: Its parameters at their word, friction and offsets fitted, shape (p,).
        after: Fitted within their tolerances beside what was found, shape (p,).
        gain_before: Drive gains at their word, shape (n,) [N m/A]; 1 where torque was recorded.
        gain_after: The same, fitted within their tolerance, shape (n,) [N m/A].
        noise: Noise floor of each joint's torque behind the filter, shape (n,) [N m].
        traces: Runs held out first.
        filtering: Of all runs.
    """

    model: Model
    before: np.ndarray
    after: np.ndarray
    gain_before: np.ndarray
    gain_after: np.ndarray
    noise: np.ndarray
    traces: tuple[Trace, ...]
    filtering: Filtering = Filtering()  # noqa: RUF009
