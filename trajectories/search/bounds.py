"""Bounds: the constraints of the optimizer, as margins that are positive inside, with their gradients.

Each margin is relative to its limit, so that 0.01 is one percent of the room. Rates and torques have a margin
to the nearer of their two limits only: this halves the number of rows for the solver, and is smooth where it
matters, since at zero both limits are far away.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..limits.brake import stopping_reach, stopping_reach_gradient
from ..limits.usable_limits import ranges
from ..trajectory import States

Slopes = tuple[np.ndarray | None, np.ndarray | None, np.ndarray | None, np.ndarray | None]
"""Derivatives by position, velocity, acceleration and jerk, each (t, m, n), or None for zero."""


class BoundMargins(NamedTuple):
    """Margins of some rows at each sample, and their derivatives by the state there."""

    value: np.ndarray  # margins, at least zero where allowed, shape (t, m) [-]
    # Function that computes the derivatives, which cost more and are needed less often.
    slopes: Callable[[], Slopes]


class Bound(ABC):
    """A constraint on the state at every sample."""

    @abstractmethod
    def margins(self, states: States) -> BoundMargins:
        """Margins and their derivatives."""


@dataclass(frozen=True, eq=False)
class RateBound(Bound):
    """Velocity, acceleration or jerk within its limits."""

    order: int  # 1 for velocity, 2 for acceleration, 3 for jerk
    lower: np.ndarray  # lower limits, below zero, shape (n,)
    upper: np.ndarray  # upper limits, above zero, shape (n,)
    joints: np.ndarray  # joints to which the bound applies, shape (k,)

    def margins(self, states: States) -> BoundMargins:
        value = (states.velocity, states.acceleration, states.jerk)[self.order - 1][:, self.joints]
        lower, upper = self.lower[self.joints], self.upper[self.joints]
        nearer = np.where(value > 0.0, upper, lower)

        def slopes() -> Slopes:
            slope = np.zeros((*value.shape, len(self.upper)))
            slope[:, np.arange(len(self.joints)), self.joints] = -1.0 / nearer
            return tuple(slope if order == self.order else None for order in range(4))  # type: ignore[return-value]

        return BoundMargins(1.0 - value / nearer, slopes)


@dataclass(frozen=True, eq=False)
class StopBound(Bound):
    """Position, and the extreme positions of a stop that begins now, within the position limits."""

    limits: Limits  # limits of all kinds; the stop uses those of acceleration and jerk

    def margins(self, states: States) -> BoundMargins:
        lower, upper = self.limits.position_lower, self.limits.position_upper
        room = 0.5 * (upper - lower)
        down, up = stopping_reach(states.velocity, states.acceleration, self.limits)
        value = [(upper - states.position - up) / room, (states.position + down - lower) / room]

        def slopes() -> Slopes:
            position = _diagonal(np.concatenate([-1.0 / room, 1.0 / room]), len(up))
            velocity, acceleration = (
                _diagonal(np.concatenate([-by.upper / room, by.lower / room], axis=1), len(up))
                for by in stopping_reach_gradient(states.velocity, states.acceleration, self.limits)
            )
            return position, velocity, acceleration, None

        return BoundMargins(np.concatenate(value, axis=1), slopes)


def _diagonal(values: np.ndarray, samples: int) -> np.ndarray:
    """Derivatives of two rows per joint, each by its joint; values (2 n,) or (t, 2 n) to (t, 2 n, n)."""
    values = np.broadcast_to(values, (samples, values.shape[-1]))
    joints = values.shape[1] // 2
    out = np.zeros((samples, 2 * joints, joints))
    rows = np.arange(2 * joints)
    out[:, rows, rows % joints] = values
    return out


def kinematic_bounds(limits: Limits, highest: float = np.inf) -> list[Bound]:
    """Bounds of position with room to stop, velocity, acceleration and jerk, whose limits are finite.

    The derivative of a series bounded by v is at most the frequency of its highest harmonic [rad/s] times v
    (Bernstein's inequality), so a looser limit of the derivative needs no bound.
    """
    bounds: list[Bound] = [StopBound(limits)]
    steepest = np.full(len(limits.velocity), np.inf)
    for order, (lower, upper) in enumerate(list(ranges(limits).values())[1:], start=1):
        joints = np.flatnonzero(np.minimum(-lower, upper) < steepest)
        if len(joints):
            bounds.append(RateBound(order, lower, upper, joints))
        steepest = highest * np.minimum(np.maximum(-lower, upper), steepest)
    return bounds


SCALE = 0.1
"""Distance that is scaled like the full range of a joint [m]: about a link's thickness."""


@dataclass(frozen=True, eq=False)
class ClearanceBound(Bound):
    """Margins of a clearance at every sample."""

    clearance: Clearance

    def margins(self, states: States) -> BoundMargins:
        value, slope = self.clearance.gradient(states.position)
        return BoundMargins(value / SCALE, lambda: (slope / SCALE, None, None, None))
