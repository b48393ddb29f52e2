"""Torque bound: torque of the nominal model."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from exidyn.identify.arm.motion import Motion
from exidyn.identify.model import Model

from ...trajectory import States
from .kinematic_bounds import Bound, Margins, Slopes


@dataclass(frozen=True, eq=False)
class TorqueBound(Bound):
    """Torque of the nominal model within the joints' limits, in every run.

    Of the joints, as URDF and data sheets have them: a drive of a coupled wrist feels a mixture of theirs,
    which is not looked at.

    Attributes:
        model: Robot and effects with their priors.
        limit: Shape (n,) [N m]; infinite where there is none.
        payloads: Body carried in each run of the same motion.
    """

    model: Model
    limit: np.ndarray
    payloads: Sequence[str] = ("",)

    def torque(self, states: States, payload: str) -> np.ndarray:
        """Nominal joint torque, shape (t, n) [N m]."""
        motion = self.model.loaded(states.motion(payload))
        return self.model.torque(motion, self.model.nominal_values)

    def of(self, payload: str) -> Callable[[States], np.ndarray]:
        """The torque of one run as a function of states alone."""
        return lambda states: self.torque(states, payload)

    def margins(self, states: States) -> Margins:
        limited = np.flatnonzero(np.isfinite(self.limit))
        shares = [self.torque(states, payload)[:, limited] / self.limit[limited] for payload in self.payloads]
        value = np.concatenate([1.0 + sign * share for share in shares for sign in (-1.0, 1.0)], axis=1)

        def slopes() -> Slopes:
            runs = [self._slopes(states, payload, limited) for payload in self.payloads]
            position, velocity, acceleration = (
                np.concatenate([sign * one for one in kind for sign in (-1.0, 1.0)], axis=1)
                for kind in zip(*runs, strict=True)
            )
            return position, velocity, acceleration, None

        return Margins(value, slopes)

    def _slopes(self, states: States, payload: str, limited: np.ndarray) -> list[np.ndarray]:
        """Derivatives of each limited joint's share, each (t, m, n).

        All joints in one pass: the motion repeated once for each, with the weights of that joint alone. Rows
        far from their limit need theirs as well: with zeros there the solver finds no way downhill.
        """
        t, n = states.position.shape
        every = np.tile(np.arange(t), len(limited))
        motion = self.model.loaded(_taken(states.motion(payload), every))
        pick = np.zeros((len(limited), t, n))
        pick[np.arange(len(limited)), :, limited] = 1.0 / self.limit[limited][:, None]
        flat = pick.reshape(-1, n)
        gradient = self.model.motion_gradient(motion, flat[:, :, None] * self.model.nominal_values, flat)
        parts = (gradient.position, gradient.velocity, gradient.acceleration)
        return [part.reshape(len(limited), t, n).swapaxes(0, 1) for part in parts]


def _taken(motion: Motion, rows: np.ndarray) -> Motion:
    """Some samples of a motion, in any order; effects with a memory see them as one run."""
    names = ("time", "position", "velocity", "acceleration", "load", "temperature")
    return replace(motion, **{name: getattr(motion, name)[rows] for name in names})
