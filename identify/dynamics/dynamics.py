"""`Dynamics`: a model at given values, as functions of scalars, without regressors."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arm.newton_euler import joints_of
from ..arm.rigid_regressor import INERTIAL
from ..arm.robot import Robot
from ..effects import Effect
from ..effects.joint_state import JointState, Scalar
from ..model import Model
from .recursion import Axis, Body, Momentum, link_momentum, link_torque

Pair = tuple[Effect, np.ndarray]
"""An effect and its parameters (p,)."""


@dataclass(frozen=True, eq=False)
class Dynamics:
    """Torque of a model at given parameter values."""

    robot: Robot  # the arm
    links: np.ndarray  # ten parameters of each link, with the payload in the last one, shape (n, 10)
    effects: tuple[Pair, ...]  # other effects with their parameters
    # Model of the torque that the gears transmit, if an effect depends on it; else None.
    loading: "Dynamics | None" = None
    # Effects that have no form without a regressor, with their parameters: they are missing.
    left_out: tuple[Pair, ...] = ()

    @classmethod
    def of(cls, model: Model, values: np.ndarray, payload: str = "") -> "Dynamics":
        """Dynamics of a model for parameters (p,) while the named payload is carried.

        The load of the gears is nominal, as in `Model.loaded`.
        """
        dynamics = cls._sorted(model, model.shares(values), payload)
        if not any(effect.needs_load for effect, _ in dynamics.effects):
            return dynamics
        shares = [pair for pair in model.shares(model.nominal_values) if pair[0].transmitted]
        loading = cls._sorted(model, shares, payload)
        return cls(
            model.robot, dynamics.links, dynamics.effects, loading, (*dynamics.left_out, *loading.left_out)
        )

    @classmethod
    def _sorted(cls, model: Model, shares: Sequence[Pair], payload: str) -> "Dynamics":
        robot, links = model.robot, np.zeros((model.robot.dof, len(INERTIAL)))
        effects, left_out = [], []
        for effect, values in shares:
            bodies = effect.link_parameters(robot, values, payload)
            if bodies is not None:
                links = links + bodies
            elif effect.joint_torque(robot, values, JointState(*[[0.0] * robot.dof] * 5)) is not None:
                effects.append((effect, values))
            elif np.any(values):
                left_out.append((effect, values))
        return cls(robot, links, tuple(effects), left_out=tuple(left_out))

    @cached_property
    def _joints(self) -> list[Axis]:
        return [Axis.of(joint) for joint in joints_of(self.robot.kinematics)]

    @cached_property
    def _bodies(self) -> list[Body]:
        return [Body.of(parameters) for parameters in self.links]

    @property
    def needs_temperature(self) -> bool:
        """Whether an effect depends on temperature."""
        return any(effect.needs_temperature for effect, _ in self.effects)

    def torque(self, state: JointState) -> list[Scalar]:
        """Torque of links and effects, one scalar per joint [N m]."""
        return _sum(self.link_torque(state), self.effect_torque(state))

    def link_torque(self, state: JointState) -> list[Scalar]:
        """Inertia, gravity, centrifugal and Coriolis torque of the links, one scalar per joint [N m]."""
        return link_torque(self._joints, self._bodies, self.robot.gravity.tolist(), state)

    def effect_torque(self, state: JointState) -> list[Scalar]:
        """Torque of all effects but the links, one scalar per joint [N m], at the gears' nominal load."""
        return _sum([0.0] * self.robot.dof, *self._effect_torques(self._loaded(state)))

    def gravity_torque(self, state: JointState) -> list[Scalar]:
        """Torque that holds the arm at rest: gravity, springs, offsets; one scalar per joint [N m]."""
        return self.torque(state.still)

    def friction_torque(self, state: JointState) -> list[Scalar]:
        """Part of the effects' torque that depends on velocity, without acceleration [N m]."""
        moving = state._replace(acceleration=state.still.acceleration)
        return self._difference(self._loaded(moving), self._loaded(state.still))

    def momentum(self, state: JointState) -> Momentum:
        """Generalized momentum [N m s] and derivative of the kinetic energy by position [N m].

        Effects contribute the part of their torque that is proportional to acceleration, such as a rotor's.
        """
        links = link_momentum(self._joints, self._bodies, state)
        accelerated = state.still._replace(acceleration=state.velocity)
        rotors = self._difference(accelerated, state.still)
        return Momentum(_sum(links.momentum, rotors), links.by_position)

    def _loaded(self, state: JointState) -> JointState:
        """The state with the nominal load of the gears, if an effect depends on it."""
        return state if self.loading is None else state._replace(load=self.loading.torque(state))

    def _effect_torques(self, state: JointState) -> list[Sequence[Scalar]]:
        """Torque of each effect but the links."""
        torques = (effect.joint_torque(self.robot, values, state) for effect, values in self.effects)
        return [torque for torque in torques if torque is not None]

    def _difference(self, state: JointState, other: JointState) -> list[Scalar]:
        """Torque of the effects in one state minus another, effect by effect, so that constants cancel."""
        pairs = zip(self._effect_torques(state), self._effect_torques(other), strict=True)
        differences = ([a - b for a, b in zip(*pair, strict=True)] for pair in pairs)
        return _sum([0.0] * self.robot.dof, *differences)


def stacked(torque: Sequence[Scalar], samples: int) -> np.ndarray:
    """Array (t, n) of one scalar or array (t,) per joint."""
    return np.stack([np.broadcast_to(np.asarray(part, float), (samples,)) for part in torque], axis=1)


def _sum(*torques: Sequence[Scalar]) -> list[Scalar]:
    return [sum(parts) for parts in zip(*torques, strict=True)]
