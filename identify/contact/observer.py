r"""`Observer`: external joint torque by the generalized momentum (De Luca, Mattone, ICRA 2003).

With the generalized momentum :math:`p = M(q) \dot q` and the torque :math:`\tau` of the motors,

.. math:: \dot p = \tau + C^T \dot q - g(q) - f(q, \dot q) + \tau_{ext},

which needs no acceleration. The residual r follows :math:`\tau_{ext}` like a first-order low-pass whose pole
is the bandwidth. Over an interval of h seconds, with the right-hand side's mean :math:`\bar s` without
:math:`\tau_{ext}` (trapezoid of both ends),

.. math:: r_k = r_{k-1} + (1 - e^{-K h}) \left( \frac{p_k - p_{k-1}}{h} - \bar s - r_{k-1} \right),

which is the exact response to an external torque that is constant over the interval, stable for any h.

Velocities are differences of two positions. Torque and position are averaged over the same two samples, and
all pass the same low-pass of two equal poles first, so that they stay simultaneous. Elastic gears are rigid
here, and at rest any torque below dry friction may be friction: the threshold is what allows for both.
"""

from dataclasses import dataclass

import numpy as np

from ..dynamics.program import compiled, fitted_dynamics
from ..effects.joint_state import JointState, Scalar
from ..errors import FitError, NotRecorded, WrongShape
from ..fit.fit import Fit
from . import BANDWIDTH

AHEAD = 4.0
"""Poles of the low-pass before the observer, over its bandwidth [-]: each delays by a quarter of the time
constant of the observer, and both take out the noise of differences."""
GAP = 0.1
"""Longest time between samples over which the observer continues [s]; after it, it starts again."""
SETTLED = 5.0
"""Time constants after which the start no longer counts [-]: 0.7 % of it is left."""


@dataclass(frozen=True, eq=False)
class Estimates:
    """External torque along a run; NaN where the observer is not settled, or a signal is missing."""

    time: np.ndarray  # time of the samples, shape (t,) [s]
    torque: np.ndarray  # external torque, positive in the direction of the joint, shape (t, n) [N m]
    position: np.ndarray  # low-passed position, shape (t, n) [rad]
    velocity: np.ndarray  # low-passed velocity, shape (t, n) [rad/s]
    load: np.ndarray  # torque of the model without acceleration: gravity and friction, shape (t, n) [N m]

    def __len__(self) -> int:
        return len(self.time)


class Observer:
    """External torque of a live arm, from samples in pieces of any length; a recording is one long piece.

    Args:
        fit: The fit, whose drive gains convert currents to torques.
        payload: Name of the payload on the flange; empty for none.
        bandwidth: Bandwidth [Hz].

    Raises:
        FitError: There is no such payload, or the bandwidth is not above 0.
    """

    def __init__(self, fit: Fit, payload: str = "", bandwidth: float = BANDWIDTH) -> None:
        self.dynamics = fitted_dynamics(fit, payload)
        if not bandwidth > 0.0:
            raise FitError(f"bandwidth of the observer is {bandwidth:g} Hz; it must be above 0")
        self.fit, self.payload, self.bandwidth = fit, payload, bandwidth
        self._functions = compiled(self.dynamics.robot.dof, ("q", "dq", "temperature"), self._quantities)
        self._gain = fit.estimate.gain if fit.measures == "current" else np.ones(fit.model.robot.dof)
        self.reset()

    def reset(self) -> None:
        """Start again, without memory of earlier samples."""
        self._time = -np.inf
        self._poles = np.zeros((2, 0))
        self._middle: tuple[float, np.ndarray, np.ndarray] | None = None
        self._residual, self._age = np.zeros(self.dynamics.robot.dof), 0.0

    def step(
        self, time: float, position: np.ndarray, effort: np.ndarray, temperature: np.ndarray | None = None
    ) -> np.ndarray:
        """Take one sample; return the external torque, shape (n,) [N m], NaN until the observer is settled.

        Args:
            time: Time of the sample [s].
            position: Joint positions, shape (n,) [rad].
            effort: Motor currents [A], or torques [N m] if the runs of the fit have torques, shape (n,).
            temperature: Joint temperatures, shape (n,) [degC], if friction depends on them.
        """
        rows = [
            None if part is None else np.asarray(part, float)[None]
            for part in (position, effort, temperature)
        ]
        estimates = self.add(np.array([time]), *rows)  # type: ignore[arg-type]
        return estimates.torque[0]

    def add(
        self,
        time: np.ndarray,
        position: np.ndarray,
        effort: np.ndarray,
        temperature: np.ndarray | None = None,
    ) -> Estimates:
        """Take further samples, arrays (t,) and (t, n) as in `step`; return an estimate for each.

        Raises:
            WrongShape: The arrays do not have one row per sample and one column per joint.
            NotRecorded: The fit has friction that depends on temperature, and none is given.
        """
        shape = (len(time), self.dynamics.robot.dof)
        warmth = np.full(shape, np.nan) if temperature is None else np.asarray(temperature, float)
        for name, part in (("position", position), ("effort", effort), ("temperature", warmth)):
            if np.shape(part) != shape:
                raise WrongShape(f"observer: {name} has shape {np.shape(part)}, expected {shape}")
        if self.dynamics.needs_temperature and temperature is None:
            raise NotRecorded("observer: friction of the fit depends on temperature, which is not given")
        model = self.fit.model
        torque = model.restored(self._gain * np.asarray(effort, float)) @ model.robot.coupling
        columns = np.concatenate([position, torque, warmth], axis=1)
        middles = [self._middle_of(float(t), row) for t, row in zip(time, columns, strict=True)]
        usable = np.array([middle is not None for middle in middles], bool)
        state = np.full((len(time), 4 * shape[1]), np.nan)
        if usable.any():
            state[usable] = np.array([middle for middle in middles if middle is not None])
        q, dq, torque, warm = np.split(state, 4, axis=1)
        momentum, rate, load = self._modelled(q, dq, warm, usable)
        rows = zip(time, usable, momentum, torque + rate, strict=True)
        residual = np.array([self._residual_at(*row) for row in rows])
        return Estimates(np.asarray(time, float), residual.reshape(shape), q, dq, load)

    def _middle_of(self, time: float, row: np.ndarray) -> np.ndarray | None:
        """Low-passed position, velocity, torque and temperature between this sample and the last, (4 n,)."""
        n = self.dynamics.robot.dof
        if not np.all(np.isfinite(row[: 2 * n])):
            return None
        step = time - self._time
        if step <= 0.0:
            return None
        if step > GAP:
            self.reset()
            self._time, self._poles = time, np.array([row, row])
            return None
        share = -np.expm1(-2.0 * np.pi * AHEAD * self.bandwidth * step)
        before = self._poles[1]
        first = self._poles[0] + share * (row - self._poles[0])
        self._poles = np.array([first, before + share * (first - before)])
        self._time = time
        now = self._poles[1]
        middle, velocity = 0.5 * (now + before), (now[:n] - before[:n]) / step
        return np.concatenate([middle[:n], velocity, middle[n : 2 * n], row[2 * n :]])

    def _modelled(
        self, q: np.ndarray, dq: np.ndarray, warmth: np.ndarray, usable: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Momentum, its rate of change without motor torque, and load, each (t, n); NaN if not usable."""
        n = self.dynamics.robot.dof
        values = np.full((len(q), 3 * n), np.nan)
        inputs = (part[usable].tolist() for part in (q, dq, warmth))
        if usable.any():
            values[usable] = [self._functions(*row) for row in zip(*inputs, strict=True)]
        momentum, change, load = np.split(values, 3, axis=1)
        return momentum, change - load, load

    def _quantities(self, state: JointState) -> list[Scalar]:
        """Momentum, derivative of the kinetic energy, and torque without acceleration, 3 n scalars."""
        momentum, change = self.dynamics.momentum(state)
        steady = state._replace(acceleration=state.still.acceleration)
        held = self.dynamics.link_torque(state.still)
        effects = self.dynamics.effect_torque(steady)
        return [*momentum, *change, *(a + b for a, b in zip(held, effects, strict=True))]

    def _residual_at(self, time: float, usable: bool, momentum: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Residual after a sample, (n,) [N m]; NaN until it is settled, and where a signal is missing."""
        unknown = np.full(len(momentum), np.nan)
        if not usable:
            return unknown
        last, self._middle = self._middle, (time, momentum, rate)
        if last is None or time - last[0] > GAP:
            self._residual, self._age = np.zeros(len(momentum)), 0.0
            return unknown
        step = time - last[0]
        share = -np.expm1(-2.0 * np.pi * self.bandwidth * step)
        mean = (momentum - last[1]) / step - 0.5 * (rate + last[2])
        self._residual = self._residual + share * (mean - self._residual)
        self._age += step
        return self._residual.copy() if self._age >= SETTLED / (2.0 * np.pi * self.bandwidth) else unknown
