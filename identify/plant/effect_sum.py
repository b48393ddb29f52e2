"""Torque of a sum of effects in a few states at once, quickly enough for every tick."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..effects import Effect
from ..motion import Motion
from ..robot import Robot

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
    """Some effects with their values, and the motion that they are asked about.

    A motion is written anew instead of made anew: its checks, and those arrays, would take longer than the
    effects do.

    Args:
        robot: The arm.
        effects: Pairs of an effect and its parameters (p,).
        payload: Name of the body that is carried.
    """

    def __init__(self, robot: Robot, effects: Sequence[tuple[Effect, np.ndarray]], payload: str) -> None:
        self.empty = not effects
        self._robot = robot
        self._linear = LinearSum.of(robot, [pair for pair in effects if pair[0].linear])
        self._effects = tuple(pair for pair in effects if not pair[0].linear)
        self._known = tuple(e for e, _ in effects if type(e).known_torque is not Effect.known_torque)
        self.forgets = all(effect.pointwise for effect, _ in effects)
        self._memory: list[Any] = [None] * len(self._effects)
        n = robot.dof
        self._motion = _motion_at_rest(n + 3, n, payload)
        # Rows: as it is; all joints a little faster; somewhat later; there with one joint accelerating.
        self._motion.acceleration[3:] = np.eye(n)

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
            load: Shape (n,) [N m]; None where nobody asks for it.
            temperature: Shape (n,) [degC].

        Returns:
            Torque without acceleration (n,) [N m], its slope by each joint's velocity (n,) [N m s/rad], and
            inertia (n, n) [kg m^2].
        """
        linear, motion = self._linear, self._motion
        force = linear.constant + linear.by_velocity @ joints.velocity
        if not self._effects:
            return force, linear.slope, linear.inertia
        motion.position[:2], motion.position[2:] = joints.position, later
        motion.velocity[:] = joints.velocity
        motion.velocity[1] += SHIFT
        motion.temperature[:] = temperature
        if load is not None:
            motion.load[:] = load
        torque = self._torque()
        slope = (torque[1] - torque[0]) / SHIFT
        inertia = (torque[3:] - torque[2]).T
        return torque[0] + force, slope + linear.slope, inertia + linear.inertia

    def remember(self, position: np.ndarray) -> None:
        """Go on to a position (n,) [rad], in what has a memory."""
        for place, (effect, _) in enumerate(self._effects):
            if not effect.pointwise:
                still = _motion_at_rest(1, len(position), self._motion.payload)
                still.position[:] = position
                _, self._memory[place] = effect.continued(self._robot, still, self._memory[place])

    def _torque(self) -> np.ndarray:
        """Torque in every row, shape (n + 3, n) [N m]."""
        robot, motion = self._robot, self._motion
        total = np.zeros(motion.position.shape)
        for place, (effect, values) in enumerate(self._effects):
            if effect.pointwise:
                total += effect.regressor(robot, motion) @ values
            else:
                total += effect.continued(robot, motion, self._memory[place])[0] @ values
        for effect in self._known:
            total += effect.known_torque(robot, motion)
        return total


def _motion_at_rest(rows: int, joints: int, payload: str) -> Motion:
    position, velocity, acceleration = np.zeros((3, rows, joints))
    return Motion.of(np.zeros(rows), position, velocity, acceleration, payload=payload)
