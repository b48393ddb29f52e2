r"""Torque of effects in a state, with the damping that a simulation step must treat implicitly.

Dry friction that reverses within a few mrad/s is too stiff for the steps of a simulation. So the part of each
joint's torque :math:`f(q, \dot q)` that depends on velocity is written as :math:`D \dot q`, with the secant
:math:`D = (f(q, \dot q) - f(q, 0)) / \dot q`. A step that treats :math:`D` implicitly is stable for any
friction and step size, settles at the torque of the formula, and never lets friction drive the joint.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..effects import Effect, JointEffect
from ..simulation.plant.forces import EffectMemory, motion_at_rest

SLOWEST = 1e-5
"""Minimum speed at which the secant is evaluated [rad/s]: a tenth of the most abrupt friction reversal."""


class Share(NamedTuple):
    """Torque of effects (n,) [N m], and its damping coefficient (n,) [N m s/rad]."""

    torque: np.ndarray
    drag: np.ndarray


class Torques:
    """Effects without inertia, each with its parameters (p,), and the memory of those that have one."""

    def __init__(self, robot: Robot, effects: Sequence[tuple[Effect, np.ndarray]]) -> None:
        self.memory = EffectMemory(robot, effects)
        self.loaded = any(effect.needs_load for effect, _ in effects)
        self._of_joints = [pair for pair in effects if isinstance(pair[0], JointEffect)]
        self._others = [pair for pair in effects if not isinstance(pair[0], JointEffect)]
        # Rows: at rest, and in motion. `_end` is at the end of the step, for effects with a memory.
        self._here, self._end, self._now = (motion_at_rest(rows, robot.dof) for rows in (2, 2, 1))

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
        for motion in (self._here, self._end, self._now) if self.memory else (self._here, self._now):
            motion.position[:], motion.load[:], motion.temperature[:] = position, load, temperature
            motion.velocity[-1] = velocity
        self._here.velocity[1] = self._end.velocity[1] = moving
        self._end.position[1] += step * moving
        at_rest, in_motion = self.memory.torque(self._of_joints, self._here, self._end)
        secant = (in_motion - at_rest) / moving
        torque = at_rest + secant * velocity
        if self._others:
            torque += self.memory.torque(self._others, self._now, self._now)[0]
        return Share(torque, np.maximum(secant, 0.0))
