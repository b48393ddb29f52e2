r"""Torque of effects in a state, cut into what a step may take as it is and what it has to make implicit.

Dry friction that reverses over some mrad/s is stiffer than any step of a simulation allows. Of each joint's
torque :math:`f(q, \dot q)` the part that moving adds is written as :math:`D \dot q`, by the secant
:math:`D = (f(q, \dot q) - f(q, 0)) / \dot q`. A step that makes :math:`D` implicit is stable whatever the
friction and the step, has the formula's torque where it comes to rest, and no friction that drives.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from ..effects import Effect, JointEffect

SLOWEST = 1e-5
"""Speed below which the secant is that of this speed [rad/s]: a tenth of the most abrupt reversal."""


class Share(NamedTuple):
    """Torque that it takes (n,) [N m], and its part by velocity (n,) [N m s/rad]."""

    torque: np.ndarray
    drag: np.ndarray


class Torques:
    """Effects with their values, those with a memory at one arm's place in time.

    Args:
        robot: The arm.
        effects: Pairs of an effect, without inertia, and its parameters (p,).
    """

    def __init__(self, robot: Robot, effects: Sequence[tuple[Effect, np.ndarray]]) -> None:
        self._robot, n = robot, robot.dof
        self.loaded = any(effect.needs_load for effect, _ in effects)
        self._of_joints = [pair for pair in effects if isinstance(pair[0], JointEffect)]
        self._others = [pair for pair in effects if not isinstance(pair[0], JointEffect)]
        self._dated = [effect for effect, _ in effects if not effect.pointwise]
        self._memory: dict[Effect, Any] = {}
        # Rows: there at rest; there as it moves. And where those with a memory are at the end of the step.
        self._here, self._end, self._now = (_motion(rows, n) for rows in (2, 2, 1))

    def at(
        self,
        position: np.ndarray,
        velocity: np.ndarray,
        step: float,
        load: np.ndarray,
        temperature: np.ndarray,
    ) -> Share:
        """Torque at positions, velocities, loads and temperatures (n,), before a step of some length [s]."""
        moving = np.where(np.abs(velocity) < SLOWEST, SLOWEST, velocity)
        for motion in (self._here, self._end, self._now) if self._dated else (self._here, self._now):
            motion.position[:], motion.load[:], motion.temperature[:] = position, load, temperature
            motion.velocity[-1] = velocity
        self._here.velocity[1] = self._end.velocity[1] = moving
        self._end.position[1] += step * moving
        rest, there = self._sum(self._of_joints, self._here, self._end)
        secant = (there - rest) / moving
        torque = rest + secant * velocity
        if self._others:
            torque += self._sum(self._others, self._now, self._now)[0]
        return Share(torque, np.maximum(secant, 0.0))

    def remember(self, position: np.ndarray) -> None:
        """Go on to a position (n,) [rad], in what has a memory."""
        if self._dated:
            self._now.position[0] = position
        for effect in self._dated:
            _, self._memory[effect] = effect.continued(self._robot, self._now, self._memory.get(effect))

    def forget(self) -> None:
        """Begin anew, as after a reset."""
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
