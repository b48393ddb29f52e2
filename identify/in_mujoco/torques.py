r"""Torque of effects in a state, with the damping that a simulation step must treat implicitly.

Dry friction that reverses within a few mrad/s is too stiff for the steps of a simulation. So the part of each
joint's torque :math:`f(q, \dot q)` that depends on velocity is written as :math:`D \dot q`, with the secant
:math:`D = (f(q, \dot q) - f(q, 0)) / \dot q`. A step that treats :math:`D` implicitly is stable for any
friction and step size, settles at the torque of the formula, and never lets friction drive the joint.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from ..effects import Effect, JointEffect

SLOWEST = 1e-5
"""Minimum speed at which the secant is evaluated [rad/s]: a tenth of the most abrupt friction reversal."""


class Share(NamedTuple):
    """Torque of effects (n,) [N m], and its damping coefficient (n,) [N m s/rad]."""

    torque: np.ndarray
    drag: np.ndarray


class Torques:
    """Effects with their values, and the memory of those that have one.

    Args:
        robot: The arm.
        effects: Pairs of an effect without inertia and its parameters (p,).
    """

    def __init__(self, robot: Robot, effects: Sequence[tuple[Effect, np.ndarray]]) -> None:
        self._robot, n = robot, robot.dof
        self.loaded = any(effect.needs_load for effect, _ in effects)
        self._of_joints = [pair for pair in effects if isinstance(pair[0], JointEffect)]
        self._others = [pair for pair in effects if not isinstance(pair[0], JointEffect)]
        self._with_memory = [effect for effect, _ in effects if not effect.pointwise]
        self._memory: dict[Effect, Any] = {}
        # Rows: at rest, and in motion. `_end` is at the end of the step, for effects with a memory.
        self._here, self._end, self._now = (_motion(rows, n) for rows in (2, 2, 1))

    def at(
        self,
        position: np.ndarray,
        velocity: np.ndarray,
        step: float,
        load: np.ndarray,
        temperature: np.ndarray,
    ) -> Share:
        """Torque at positions, velocities, loads and temperatures (n,), for a step of some duration [s]."""
        moving = np.where(np.abs(velocity) < SLOWEST, SLOWEST, velocity)
        for motion in (self._here, self._end, self._now) if self._with_memory else (self._here, self._now):
            motion.position[:], motion.load[:], motion.temperature[:] = position, load, temperature
            motion.velocity[-1] = velocity
        self._here.velocity[1] = self._end.velocity[1] = moving
        self._end.position[1] += step * moving
        at_rest, in_motion = self._sum(self._of_joints, self._here, self._end)
        secant = (in_motion - at_rest) / moving
        torque = at_rest + secant * velocity
        if self._others:
            torque += self._sum(self._others, self._now, self._now)[0]
        return Share(torque, np.maximum(secant, 0.0))

    def remember(self, position: np.ndarray) -> None:
        """Move the effects that have a memory on to a position (n,) [rad]."""
        if self._with_memory:
            self._now.position[0] = position
        for effect in self._with_memory:
            _, self._memory[effect] = effect.continued(self._robot, self._now, self._memory.get(effect))

    def forget(self) -> None:
        """Clear the memory, as after a reset."""
        self._memory.clear()

    def _sum(self, effects: Sequence[tuple[Effect, np.ndarray]], here: Motion, end: Motion) -> np.ndarray:
        """Torque in every row, shape (rows, n) [N m]."""
        total = np.zeros(here.position.shape)
        for effect, values in effects:
            if effect.pointwise:
                total += effect.regressor(self._robot, here) @ values
            else:
                total += effect.continued(self._robot, end, self._memory.get(effect))[0] @ values
        return total


def _motion(rows: int, joints: int) -> Motion:
    position, velocity, acceleration = np.zeros((3, rows, joints))
    return Motion.of(np.zeros(rows), position, velocity, acceleration)
