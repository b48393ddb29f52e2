"""Forces of all effects of a model in the plant's coordinates, fast enough for every command period.

Pinocchio computes rigid bodies in microseconds; all other effects are evaluated by their regressors. Torque
that the gears transmit acts on the links, all other torque on the motors.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from ...arm.motion import Motion
from ...arm.robot import Robot
from ...effects import Effect
from ...model import Model
from .gears import Transmission
from .steps import Forces

SHIFT = 1e-5
"""Velocity difference for slopes [rad/s]: a tenth of the most abrupt friction reversal."""


class Joints(NamedTuple):
    """Motion of the joints, each of shape (n,) or (x,)."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


class LinearSum(NamedTuple):
    """Torque of effects that are linear in velocity and acceleration.

    It holds a constant (n,) [N m], damping by velocity (n, n) [N m s/rad], the slope when all velocities grow
    equally (n,), and the inertia (n, n) [kg m^2].
    """

    constant: np.ndarray
    by_velocity: np.ndarray
    slope: np.ndarray
    inertia: np.ndarray

    @classmethod
    def of(cls, robot: Robot, effects: Sequence[tuple[Effect, np.ndarray]]) -> "LinearSum":
        """Evaluate each effect at rest, and at unit velocity and unit acceleration of each joint."""
        n = robot.dof
        motion = motion_at_rest(1 + 2 * n, n, "")
        motion.velocity[1 : n + 1] = motion.acceleration[n + 1 :] = np.eye(n)
        zero = np.zeros(motion.position.shape)
        torque = sum((effect.regressor(robot, motion) @ values for effect, values in effects), zero)
        constant, (drag, inertia) = torque[0], np.split((torque[1:] - torque[0]).T, 2, axis=1)
        return cls(constant, drag, drag.sum(axis=1), inertia)


def motion_at_rest(rows: int, joints: int, payload: str = "") -> Motion:
    """A motion of some rows, to write into."""
    position, velocity, acceleration = np.zeros((3, rows, joints))
    return Motion.of(np.zeros(rows), position, velocity, acceleration, payload=payload)


class EffectMemory:
    """Torque of effects with parameters (p,), and the memory of those that depend on past positions."""

    def __init__(self, robot: Robot, effects: Sequence[tuple[Effect, np.ndarray]], payload: str = "") -> None:
        self._robot, self._still = robot, motion_at_rest(1, robot.dof, payload)
        self._remembering = [effect for effect, _ in effects if not effect.pointwise]
        self._states: dict[Effect, Any] = {}

    def __bool__(self) -> bool:
        return bool(self._remembering)

    def remember(self, position: np.ndarray) -> None:
        """Move the effects that have a memory on to a position (n,) [rad]."""
        self._still.position[:] = position
        for effect in self._remembering:
            _, self._states[effect] = effect.continued(self._robot, self._still, self._states.get(effect))

    def forget(self) -> None:
        """Clear the memory, as after a reset."""
        self._states.clear()

    def torque(self, effects: Sequence[tuple[Effect, np.ndarray]], motion: Motion, end: Motion) -> np.ndarray:
        """Torque in every row of a motion, with a memory in every row of `end`, shape (t, n) [N m]."""
        robot, total = self._robot, np.zeros(motion.position.shape)
        for effect, values in effects:
            if effect.pointwise:
                total += effect.regressor(robot, motion) @ values
            else:
                total += effect.continued(robot, end, self._states.get(effect))[0] @ values
            if type(effect).known_torque is not Effect.known_torque:
                total += effect.known_torque(robot, motion)
        return total


class EffectSum:
    """Sum of effects with parameters (p,), and the motions at which they are evaluated.

    Motions are overwritten instead of created, because their arrays and checks would take longer than the
    effects.
    """

    def __init__(self, robot: Robot, effects: Sequence[tuple[Effect, np.ndarray]], payload: str) -> None:
        self.empty = not effects
        n, self.memory = robot.dof, EffectMemory(robot, effects, payload)
        self._linear = LinearSum.of(robot, [pair for pair in effects if pair[0].linear])
        self._effects = [pair for pair in effects if not pair[0].linear]
        self._heavy = [pair for pair in self._effects if not pair[0].massless]
        # Rows: the current motion; all joints a little faster.
        self._here = motion_at_rest(2, n, payload)
        # Rows: the later position; the same with one joint accelerating.
        self._later = motion_at_rest(1 + n, n, payload)
        self._later.acceleration[1:] = np.eye(n)

    def at(
        self, joints: Joints, later: np.ndarray, load: np.ndarray | None, temperature: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Torque without acceleration (n,) [N m], its slope by velocity (n,) [N m s/rad], and inertia (n, n).

        The acceleration of the joints is ignored, and the inertia [kg m^2] is that at a later position (n,)
        [rad]. The load of the gears is (n,) [N m], None if no effect needs it, the temperature (n,) [degC].
        """
        linear = self._linear
        force = linear.constant + linear.by_velocity @ joints.velocity
        slope, inertia = linear.slope, linear.inertia
        if self._effects:
            _write(self._here, joints.position, joints.velocity, load, temperature)
            self._here.velocity[1] += SHIFT
            torque, faster = self.memory.torque(self._effects, self._here, self._here)
            force, slope = force + torque, slope + (faster - torque) / SHIFT
        if self._heavy:
            _write(self._later, later, joints.velocity, load, temperature)
            torque = self.memory.torque(self._heavy, self._later, self._later)
            inertia = inertia + (torque[1:] - torque[0]).T
        return force, slope, inertia


def _write(
    motion: Motion,
    position: np.ndarray,
    velocity: np.ndarray,
    load: np.ndarray | None,
    temperature: np.ndarray,
) -> None:
    """Write the same values (n,) into every row of a motion."""
    motion.position[:], motion.velocity[:], motion.temperature[:] = position, velocity, temperature
    if load is not None:
        motion.load[:] = load


class ArmForces:
    """Sum of a model's effects with parameters (p,), evaluated at successive states."""

    def __init__(self, model: Model, values: np.ndarray, payload: str, transmission: Transmission) -> None:
        self._rigid = len(transmission.elastic) == 0
        self._links, self._motors = transmission.links, transmission.motors
        self._kinematics, others = model.bodies_apart(values, payload)
        groups: dict[bool, list[tuple[Effect, np.ndarray]]] = {True: [], False: []}
        for effect, parameters in others:
            groups[effect.transmitted].append((effect, parameters))
        self._data = self._kinematics.createData()
        self._on_links, self._on_motors = (EffectSum(model.robot, groups[t], payload) for t in (True, False))
        self.loaded = any(effect.needs_load for effect, _ in groups[False])
        self._zero, self._massless = np.zeros(model.robot.dof), np.zeros((model.robot.dof,) * 2)
        self.friction = self._zero

    def at(self, state: Joints, later: np.ndarray, temperature: np.ndarray) -> tuple[Forces, np.ndarray]:
        """Forces in a state, and inertia (x, x) [kg m^2] at a later position.

        Sets `friction`, the torque on the motor side of the gears, shape (n,) [N m]. The state and the later
        position (x,) [rad] are in the plant's coordinates; acceleration affects only the load of the gears.
        """
        if self._rigid:
            force, slope, inertia, load = self._link_side(state, later, temperature)
            self.friction, steep, mass = self._motor_side(state, later, load, temperature)
            return Forces(force + self.friction, slope + steep, state.velocity), inertia + mass
        links, motors = self._links, self._motors
        link, motor = (Joints(*(side @ values for values in state)) for side in (links, motors))
        force, slope, inertia, load = self._link_side(link, links @ later, temperature)
        self.friction, steep, mass = self._motor_side(motor, motors @ later, load, temperature)
        force, slope = links.T @ force + motors.T @ self.friction, links.T @ slope + motors.T @ steep
        return Forces(force, slope, state.velocity), links.T @ inertia @ links + motors.T @ mass @ motors

    def holding(
        self, links: np.ndarray, motors: np.ndarray, temperature: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Torque on links and on motors that holds the arm at rest, each (n,) [N m]."""
        zero = self._zero
        load = self._link_side(Joints(links, zero, zero), links, temperature)[0]
        return load, self._motor_side(Joints(motors, zero, zero), motors, load, temperature)[0]

    def remember(self, position: np.ndarray) -> None:
        """Move the effects that have a memory on to the position (x,) [rad] that the arm has reached."""
        for side, matrix in ((self._on_links, self._links), (self._on_motors, self._motors)):
            if side.memory:
                side.memory.remember(matrix @ position)

    def _link_side(
        self, link: Joints, later: np.ndarray, temperature: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]:
        """Torque, slope and inertia on the link side of the gears, and their load if an effect needs it."""
        inertia, slope = pin.crba(self._kinematics, self._data, later), self._zero
        force = pin.nonLinearEffects(self._kinematics, self._data, link.position, link.velocity)
        if not self._on_links.empty:
            more, slope, mass = self._on_links.at(link, later, None, temperature)
            force, inertia = force + more, inertia + mass
        return force, slope, inertia, force + inertia @ link.acceleration if self.loaded else None

    def _motor_side(
        self, motor: Joints, later: np.ndarray, load: np.ndarray | None, temperature: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if self._on_motors.empty:
            return self._zero, self._zero, self._massless
        return self._on_motors.at(motor, later, load, temperature)
