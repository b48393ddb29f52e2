"""Torque bound: torque of the nominal model, with room for what is not known of it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.motion import Motion
from exidyn.identification.model import Model

from ..trajectory import States
from .bounds import Bound, Margins, Slopes
from .torque_spread import TorqueSpread

CHUNK = 20000
"""Samples whose columns are held at once; some tens of megabytes, and more than a search looks at."""

NEAR = 0.5
"""Margin, as a share of the limit, above which a row does without the derivatives of its band."""


@dataclass(frozen=True, eq=False)
class TorqueBound(Bound):
    """Torque of the nominal model, and the band about it, within the joints' limits, in every run.

    Of the joints, as URDF and data sheets have them: a drive of a coupled wrist feels a mixture of theirs,
    which is not looked at. In the band the load on gears counts as nominal.

    Attributes:
        model: Robot and effects with their priors.
        limit: Shape (n,) [N m]; infinite where there is none.
        payloads: Body carried in each run of the same motion.
        spread: What is not known of the model's parameters; None where the nominal torque alone counts.
    """

    model: Model
    limit: np.ndarray
    payloads: Sequence[str] = ("",)
    spread: TorqueSpread | None = None

    def torque(self, states: States, payload: str) -> np.ndarray:
        """Nominal joint torque, shape (t, n) [N m]."""
        kinematics, others, values = self._parts(payload)
        motion = others.loaded(states.motion(payload))
        starts = range(0, len(motion), CHUNK)  # a run of minutes has a gigabyte of columns
        effects = [others.torque(motion[start : start + CHUNK], values) for start in starts]
        return _of_bodies(kinematics, motion) + np.concatenate(effects)

    def band(self, states: States, payload: str) -> np.ndarray:
        """Half the width of the band about the nominal torque, shape (t, n) [N m]."""
        if self.spread is None or self.spread.factor == 0.0:
            return np.zeros_like(states.position)
        motion, spread = states.motion(payload), self.spread
        starts = range(0, len(motion), CHUNK)
        return np.concatenate(
            [spread.band(_columns(self.model, motion[start : start + CHUNK])) for start in starts]
        )

    def of(self, payload: str) -> Callable[[States], np.ndarray]:
        """The larger end of the band in one run, signed like the torque, as a function of states alone."""

        def farthest(states: States) -> np.ndarray:
            torque = self.torque(states, payload)
            return torque + np.copysign(self.band(states, payload), torque)

        return farthest

    def margins(self, states: States) -> Margins:
        limited = np.flatnonzero(np.isfinite(self.limit))
        torques = [self.torque(states, payload)[:, limited] for payload in self.payloads]
        bands = [self.band(states, payload)[:, limited] for payload in self.payloads]
        rows = [
            1.0 - (np.abs(torque) + band) / self.limit[limited]
            for torque, band in zip(torques, bands, strict=True)
        ]

        def slopes() -> Slopes:
            found = []
            for payload, torque, row in zip(self.payloads, torques, rows, strict=True):
                sign = np.where(torque > 0.0, 1.0, -1.0)[:, :, None]
                nominal = self._slopes(states, payload, limited)
                band = self._band_slopes(states, payload, limited, row)
                found.append([-sign * one - other for one, other in zip(nominal, band, strict=True)])
            position, velocity, acceleration = (
                np.concatenate(parts, axis=1) for parts in zip(*found, strict=True)
            )
            return position, velocity, acceleration, None

        return Margins(np.concatenate(rows, axis=1), slopes)

    @cached_property
    def _made(self) -> dict[str, tuple[pin.Model, Model, np.ndarray]]:
        return {}

    def _parts(self, payload: str) -> tuple[pin.Model, Model, np.ndarray]:
        """Bodies of a run, and all other effects with their values."""
        if payload not in self._made:
            self._made[payload] = self._apart(payload)
        return self._made[payload]

    def _apart(self, payload: str) -> tuple[pin.Model, Model, np.ndarray]:
        model, values = self.model, self.model.nominal_values
        if any(effect.needs_load for effect in model.effects):  # which includes that of bodies
            return replace(model, effects=()).bodies_apart(np.zeros(0), "")[0], model, values
        kinematics, others = model.bodies_apart(values, payload)
        rest = replace(model, effects=tuple(effect for effect, _ in others))
        return kinematics, rest, np.concatenate([np.zeros(0), *(own for _, own in others)])

    def _slopes(self, states: States, payload: str, limited: np.ndarray) -> list[np.ndarray]:
        """Derivatives of each limited joint's share, each (t, m, n).

        Rows far from their limit need theirs as well: with zeros there the solver finds no way downhill.
        """
        kinematics, others, values = self._parts(payload)
        motion = others.loaded(states.motion(payload))
        by_bodies = _derivatives_of_bodies(kinematics, motion)[:, :, limited] / self.limit[limited][:, None]
        by_others = _by_motion(others, values, motion, limited, 1.0 / self.limit[limited])
        return [one + other for one, other in zip(by_bodies, by_others, strict=True)]

    def _band_slopes(
        self, states: States, payload: str, limited: np.ndarray, margin: np.ndarray
    ) -> np.ndarray:
        """Derivatives of the band of each limited joint over its limit, (3, t, m, n); zeros without one.

        They cost as much as all else together, so only rows have them whose margin (t, m) is below `NEAR`:
        the nominal torque's derivatives show the others the way.
        """
        rows, places = np.nonzero(margin < NEAR)
        found = np.zeros((3, *margin.shape, self.model.robot.dof))
        if self.spread is not None and self.spread.factor > 0.0 and len(rows):
            motion = _taken(self.model.loaded(states.motion(payload)), rows)
            columns, joints = self.model.regressor(motion), limited[places]
            weights = self.spread.weights(columns, joints) / self.limit[joints][:, None, None]
            gradient = self.model.motion_gradient(motion, weights)
            found[:, rows, places] = gradient.position, gradient.velocity, gradient.acceleration
        return found


def _columns(model: Model, motion: Motion) -> np.ndarray:
    """Torque per unit of each parameter, the loads of gears by the model, shape (t, n, p)."""
    return model.regressor(model.loaded(motion))


def _of_bodies(kinematics: pin.Model, motion: Motion) -> np.ndarray:
    """Torque of rigid bodies, shape (t, n) [N m]."""
    data = kinematics.createData()
    states = zip(motion.position, motion.velocity, motion.acceleration, strict=True)
    return np.array([pin.rnea(kinematics, data, *state) for state in states])


def _derivatives_of_bodies(kinematics: pin.Model, motion: Motion) -> np.ndarray:
    """Of the same by position, velocity and acceleration, shape (3, t, n, n)."""
    data, found = kinematics.createData(), np.empty((3, *motion.position.shape, kinematics.nv))
    states = zip(motion.position, motion.velocity, motion.acceleration, strict=True)
    for place, state in enumerate(states):
        found[:, place] = pin.computeRNEADerivatives(kinematics, data, *state)
    return found


def _by_motion(
    model: Model, values: np.ndarray, motion: Motion, joints: np.ndarray, scale: np.ndarray
) -> list[np.ndarray]:
    """Derivatives of a model's torque on some joints (m,), each times its scale, each (t, m, n).

    All joints in one pass: the motion repeated once for each, with the weights of that joint alone.
    """
    t, n = motion.position.shape
    repeated = _taken(motion, np.tile(np.arange(t), len(joints)))
    pick = np.zeros((len(joints), t, n))
    pick[np.arange(len(joints)), :, joints] = scale[:, None]
    flat = pick.reshape(-1, n)
    gradient = model.motion_gradient(repeated, flat[:, :, None] * values, flat)
    parts = (gradient.position, gradient.velocity, gradient.acceleration)
    return [part.reshape(len(joints), t, n).swapaxes(0, 1) for part in parts]


def _taken(motion: Motion, rows: np.ndarray) -> Motion:
    """Some samples of a motion, in any order; effects with a memory see them as one run."""
    names = ("time", "position", "velocity", "acceleration", "load", "temperature")
    return replace(motion, **{name: getattr(motion, name)[rows] for name in names})
