"""Torque of a sum of effects in a few states at once, quickly enough for every tick."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...arm.motion import Motion
from ...arm.robot import Robot
from ...effects import Effect

SHIFT = 1e-5
"""By which velocities are shifted to find slopes [rad/s]: a tenth of the most abrupt reversal there is."""


class Joints(NamedTuple):
    """How joints move, each of shape (n,) or (x,)."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


class LinearSum(NamedTuple):
    """Torque of effects that are linear in velocity and acceleration.

    Attributes:
        constant: Shape (n,) [N m].
        by_velocity: Shape (n, n) [N m s/rad].
        slope: Of each joint when all become faster alike, shape (n,) [N m s/rad].
        inertia: Shape (n, n) [kg m^2].
    """

    constant: np.ndarray
    by_velocity: np.ndarray
    slope: np.ndarray
    inertia: np.ndarray

    @classmethod
    def of(cls, robot: Robot, effects: Sequence[tuple[Effect, np.ndarray]]) -> "LinearSum":
        """Ask each effect about rest, each joint's velocity alone, and each joint's acceleration alone."""
        n = robot.dof
        motion = _motion_at_rest(1 + 2 * n, n, "")
        motion.velocity[1 : n + 1] = motion.acceleration[n + 1 :] = np.eye(n)
        none = np.zeros(motion.position.shape)
        torque = sum((effect.regressor(robot, motion) @ own for effect, own in effects), none)
        constant, (drag, inertia) = torque[0], np.split((torque[1:] - torque[0]).T, 2, axis=1)
        return cls(constant, drag, drag.sum(axis=1), inertia)


class EffectSum:
    """Some effects with their values, and the motions that they are asked about.

    Motions are written anew instead of made anew: their checks, and those arrays, would take longer than the
    effects do.

    Args:
        robot: The arm.
        effects: Pairs of an effect and its parameters (p,).
        payload: Name of the body that is carried.
    """

    def __init__(self, robot: Robot, effects: Sequence[tuple[Effect, np.ndarray]], payload: str) -> None:
        self.empty = not effects
        self.forgets = all(effect.pointwise for effect, _ in effects)
        self._robot, n = robot, robot.dof
        self._linear = LinearSum.of(robot, [pair for pair in effects if pair[0].linear])
        self._effects = [pair for pair in effects if not pair[0].linear]
        self._heavy = [pair for pair in self._effects if not pair[0].massless]
        self._memory: dict[Effect, Any] = {}
        # Rows: as it is; all joints a little faster.
        self._here = _motion_at_rest(2, n, payload)
        # Rows: somewhat later; there with one joint accelerating.
        self._later = _motion_at_rest(1 + n, n, payload)
        self._later.acceleration[1:] = np.eye(n)

    def at(
        self,
        joints: Joints,
        later: np.ndarray,
        load: np.ndarray | None,
        temperature: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What the effects ask for.

        Args:
            joints: Where the arm is; without acceleration.
            later: Where their inertia is wanted, shape (n,) [rad].
            load: Shape (n,) [N m]; None where no effect needs it.
            temperature: Shape (n,) [degC].

        Returns:
            Torque without acceleration (n,) [N m], its slope by each joint's velocity (n,) [N m s/rad], and
            inertia (n, n) [kg m^2].
        """
        linear = self._linear
        force, slope, inertia = (
            linear.constant + linear.by_velocity @ joints.velocity,
            linear.slope,
            linear.inertia,
        )
        if self._effects:
            _write(self._here, joints.position, joints.velocity, load, temperature)
            self._here.velocity[1] += SHIFT
            torque, faster = self._torque(self._effects, self._here)
            force, slope = force + torque, slope + (faster - torque) / SHIFT
        if self._heavy:
            _write(self._later, later, joints.velocity, load, temperature)
            torque = self._torque(self._heavy, self._later)
            inertia = inertia + (torque[1:] - torque[0]).T
        return force, slope, inertia

    def remember(self, position: np.ndarray) -> None:
        """Go on to a position (n,) [rad], in what has a memory."""
        for effect, _ in self._effects:
            if not effect.pointwise:
                still = _motion_at_rest(1, len(position), self._here.payload)
                still.position[:] = position
                _, self._memory[effect] = effect.continued(self._robot, still, self._memory.get(effect))

    def _torque(self, effects: Sequence[tuple[Effect, np.ndarray]], motion: Motion) -> np.ndarray:
        """Torque in every row, shape (t, n) [N m]."""
        robot = self._robot
        total = np.zeros(motion.position.shape)
        for effect, values in effects:
            if effect.pointwise:
                total += effect.regressor(robot, motion) @ values
            else:
                total += effect.continued(robot, motion, self._memory.get(effect))[0] @ values
            if type(effect).known_torque is not Effect.known_torque:
                total += effect.known_torque(robot, motion)
        return total


def _write(
    motion: Motion,
    position: np.ndarray,
    velocity: np.ndarray,
    load: np.ndarray | None,
    temperature: np.ndarray,
) -> None:
    """The same in every row, each (n,)."""
    motion.position[:], motion.velocity[:], motion.temperature[:] = position, velocity, temperature
    if load is not None:
        motion.load[:] = load


def _motion_at_rest(rows: int, joints: int, payload: str) -> Motion:
    position, velocity, acceleration = np.zeros((3, rows, joints))
    return Motion.of(np.zeros(rows), position, velocity, acceleration, payload=payload)
