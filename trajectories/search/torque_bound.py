"""Torque bound: torque of the nominal model with room for its uncertainty, and how many arms exceed a limit.

The band that contains the entire torque of a share of arms is wider than necessary: a motion is near a limit
for some joints at some times only. So each motion gets its own factor, with which few sampled arms exceed
limits that the band is as close to as it is to the actual limits.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.motion import Motion
from exidyn.identification.model import Model

from ..trajectory import States
from .goals import Goal
from .problem import Bound, BoundMargins, Slopes
from .torque_spread import TorqueSpread

CHUNK = 20000
"""Number of samples whose regressor is in memory at once; tens of megabytes, and more than a search needs."""

NEAR = 0.5
"""Margin, as a share of the limit, above which the derivatives of a row's band are omitted."""


@dataclass(frozen=True, eq=False)
class TorqueBound(Bound):
    """Torque of the nominal model, and the band about it, within the joint limits, in every run.

    Limits apply to joint torques, as in URDF and data sheets; torques of the drives of a coupled wrist, which
    mix joint torques, are not checked. The band uses the nominal gear loads.
    """

    model: Model  # robot and effects with their priors
    limit: np.ndarray  # torque limits, shape (n,) [N m]; infinite for none
    payloads: Sequence[str] = ("",)  # payload in each run of the same motion
    # Uncertainty of the model's parameters; None for the nominal torque alone.
    spread: TorqueSpread | None = None

    def torque(self, states: States, payload: str) -> np.ndarray:
        """Nominal joint torque, shape (t, n) [N m]."""
        kinematics, others, values = self._parts[payload]
        motion = others.loaded(states.motion(payload))
        starts = range(0, len(motion), CHUNK)  # the regressor of a run of minutes takes a gigabyte
        effects = [others.torque(motion[start : start + CHUNK], values) for start in starts]
        return _body_torque(kinematics, motion) + np.concatenate(effects)

    def band(self, states: States, payload: str) -> np.ndarray:
        """Half the width of the band about the nominal torque, shape (t, n) [N m]."""
        if self.spread is None or self.spread.factor == 0.0:
            return np.zeros_like(states.position)
        model, motion, spread = self.model, states.motion(payload), self.spread
        parts = [motion[start : start + CHUNK] for start in range(0, len(motion), CHUNK)]
        return np.concatenate([spread.band(model.regressor(model.loaded(part))) for part in parts])

    def of(self, payload: str) -> Callable[[States], np.ndarray]:
        """Function from states to the end of the band with the larger absolute torque in one run."""

        def farthest(states: States) -> np.ndarray:
            torque = self.torque(states, payload)
            return torque + np.copysign(self.band(states, payload), torque)

        return farthest

    def margins(self, states: States) -> BoundMargins:
        limited = np.flatnonzero(np.isfinite(self.limit))
        torques = [self.torque(states, payload)[:, limited] for payload in self.payloads]
        bands = [self.band(states, payload)[:, limited] for payload in self.payloads]
        rows = [
            1.0 - (np.abs(torque) + band) / self.limit[limited]
            for torque, band in zip(torques, bands, strict=True)
        ]

        def slopes() -> Slopes:
            run_slopes = []
            for payload, torque, row in zip(self.payloads, torques, rows, strict=True):
                sign = np.where(torque > 0.0, 1.0, -1.0)[:, :, None]
                nominal_slopes = self._slopes(states, payload, limited)
                band_slopes = self._band_slopes(states, payload, limited, row)
                pairs = zip(nominal_slopes, band_slopes, strict=True)
                run_slopes.append([-sign * nominal - band for nominal, band in pairs])
            position, velocity, acceleration = (
                np.concatenate(parts, axis=1) for parts in zip(*run_slopes, strict=True)
            )
            return position, velocity, acceleration, None

        return BoundMargins(np.concatenate(rows, axis=1), slopes)

    @cached_property
    def _parts(self) -> dict[str, tuple[pin.Model, Model, np.ndarray]]:
        """Rigid bodies of each run, and a model of all other effects with its parameter values."""
        return {payload: self._split(payload) for payload in self.payloads}

    def _split(self, payload: str) -> tuple[pin.Model, Model, np.ndarray]:
        model, values = self.model, self.model.nominal_values
        if any(effect.needs_load for effect in model.effects):  # the load includes that of the bodies
            return replace(model, effects=()).bodies_apart(np.zeros(0), "")[0], model, values
        kinematics, others = model.bodies_apart(values, payload)
        other_model = replace(model, effects=tuple(effect for effect, _ in others))
        other_values = np.concatenate([np.zeros(0), *(effect_values for _, effect_values in others)])
        return kinematics, other_model, other_values

    def _slopes(self, states: States, payload: str, limited: np.ndarray) -> list[np.ndarray]:
        """Derivatives of each limited joint's torque over its limit, each (t, m, n).

        Rows far from their limit need them as well: with zeros the solver finds no descent direction.
        """
        kinematics, others, values = self._parts[payload]
        motion = others.loaded(states.motion(payload))
        by_bodies = _body_torque_derivatives(kinematics, motion)[:, :, limited] / self.limit[limited][:, None]
        by_others = _by_motion(others, values, motion, limited, 1.0 / self.limit[limited])
        return [bodies + others for bodies, others in zip(by_bodies, by_others, strict=True)]

    def _band_slopes(
        self, states: States, payload: str, limited: np.ndarray, margin: np.ndarray
    ) -> np.ndarray:
        """Derivatives of the band of each limited joint over its limit, (3, t, m, n); zeros without a band.

        They cost as much as all else together, so they are computed only for rows whose margin, shape (t, m),
        is below `NEAR`: for the others the derivatives of the nominal torque suffice.
        """
        rows, places = np.nonzero(margin < NEAR)
        slopes = np.zeros((3, *margin.shape, self.model.robot.dof))
        if self.spread is not None and self.spread.factor > 0.0 and len(rows):
            motion = _select_rows(self.model.loaded(states.motion(payload)), rows)
            columns, joints = self.model.regressor(motion), limited[places]
            weights = self.spread.weights(columns, joints) / self.limit[joints][:, None, None]
            gradient = self.model.motion_gradient(motion, weights)
            slopes[:, rows, places] = gradient.position, gradient.velocity, gradient.acceleration
        return slopes


def _body_torque(kinematics: pin.Model, motion: Motion) -> np.ndarray:
    """Torque of the rigid bodies, shape (t, n) [N m]."""
    data = kinematics.createData()
    states = zip(motion.position, motion.velocity, motion.acceleration, strict=True)
    return np.array([pin.rnea(kinematics, data, *state) for state in states])


def _body_torque_derivatives(kinematics: pin.Model, motion: Motion) -> np.ndarray:
    """Derivatives of `_body_torque` by position, velocity and acceleration, shape (3, t, n, n)."""
    data, derivatives = kinematics.createData(), np.empty((3, *motion.position.shape, kinematics.nv))
    states = zip(motion.position, motion.velocity, motion.acceleration, strict=True)
    for place, state in enumerate(states):
        derivatives[:, place] = pin.computeRNEADerivatives(kinematics, data, *state)
    return derivatives


def _by_motion(
    model: Model, values: np.ndarray, motion: Motion, joints: np.ndarray, scale: np.ndarray
) -> list[np.ndarray]:
    """Derivatives of a model's torque on some joints, shape (m,), each times its scale, each (t, m, n).

    All joints are computed in one pass: the motion is repeated for each, with the weights of that joint
    alone.
    """
    t, n = motion.position.shape
    repeated = _select_rows(motion, np.tile(np.arange(t), len(joints)))
    pick = np.zeros((len(joints), t, n))
    pick[np.arange(len(joints)), :, joints] = scale[:, None]
    flat = pick.reshape(-1, n)
    gradient = model.motion_gradient(repeated, flat[:, :, None] * values, flat)
    parts = (gradient.position, gradient.velocity, gradient.acceleration)
    return [part.reshape(len(joints), t, n).swapaxes(0, 1) for part in parts]


def _select_rows(motion: Motion, rows: np.ndarray) -> Motion:
    """Some samples of a motion, in any order; effects with memory treat them as one run."""
    names = ("time", "position", "velocity", "acceleration", "load", "temperature")
    return replace(motion, **{name: getattr(motion, name)[rows] for name in names})


AIM = 0.5
"""Share of the admissible violations for which a factor is chosen: the motion changes afterwards, and the
samples scatter."""
STEPS = 20
"""Number of bisections: a resolution of a millionth of the widest factor."""


def _without_limits(goal: Goal) -> TorqueBound:
    return TorqueBound(goal.model, np.full(goal.model.robot.dof, np.inf), goal.payloads, goal.spread)


def peaks(goal: Goal, states: States) -> np.ndarray:
    """Largest torque of each sampled arm and joint in all runs of a motion, shape (k, n) [N m]."""
    assert goal.spread is not None
    bound = _without_limits(goal)
    run_peaks = [
        goal.spread.peaks(goal.model, states.motion(payload), bound.torque(states, payload))
        for payload in goal.payloads
    ]
    return np.asarray(np.max(run_peaks, axis=0))


def share_beyond(goal: Goal, states: States, limit: np.ndarray) -> float:
    """Share of sampled arms that exceed a torque limit, shape (n,), in any joint, sample and run."""
    if goal.spread is None:
        return 0.0
    return goal.spread.share_beyond(peaks(goal, states), limit)


def with_own_factor(goal: Goal, states: States, limit: np.ndarray) -> Goal:
    """The goal with the band factor that this motion needs at its present distance to the limits, shape (n,).

    A motion that exceeds the limits with the present factor is treated as one that just keeps to them.
    """
    spread = goal.spread
    if spread is None or spread.widest == 0.0:
        return goal
    drawn, reach = peaks(goal, states), _reach(goal, spread, states)
    slack = np.maximum(limit / reach(spread.factor), 1.0)

    def enough(factor: float) -> bool:
        beyond = replace(spread, factor=factor).share_beyond(drawn, slack * reach(factor))
        return beyond <= AIM * (1.0 - spread.share)

    low, high = 0.0, spread.widest
    if enough(low):  # the motion is far from torque limits, so the band does not restrict a search
        return goal.with_spread(replace(spread, factor=low))
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if enough(middle) else (middle, high)
    return goal.with_spread(replace(spread, factor=high))


def _reach(goal: Goal, spread: TorqueSpread, states: States) -> Callable[[float], np.ndarray]:
    """Function from factor to largest absolute torque in the band of each joint, shape (n,) [N m]."""
    bound = _without_limits(goal.with_spread(replace(spread, factor=1.0)))
    torque = np.abs(np.concatenate([bound.torque(states, payload) for payload in goal.payloads]))
    deviation = np.concatenate([bound.band(states, payload) for payload in goal.payloads])
    return lambda factor: np.max(torque + factor * deviation, axis=0)
