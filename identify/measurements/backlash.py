"""A gear with play: while its teeth change sides, its link floats and no motor carries it."""

from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from ..arm.tangent import Tangent
from .gear import Gear, Spring
from .measurement import require
from .twist import Twist, loose, resting

TEETH = 40.0
"""Resonance of a link on its teeth [Hz]: harder ones strike alike behind a low-pass of 25 Hz, softer ones
are an elastic gear's."""
RATIO = 0.5
"""Damping ratio of the teeth, and of the drive that is pushed back by them [-]."""


@dataclass(frozen=True)
class Backlash(Gear):
    """Play between two sides of the teeth.

    Attributes:
        gap: Whole width of the play, seen from the joint [rad].
        damping_ratio: Damping ratio of the link on its teeth [-].
        load_shift: Torque by which the load exceeds that of the model [N m].
    """

    gap: float
    damping_ratio: float = RATIO
    load_shift: float = 0.0

    def twist(self, tangent: Tangent, load: np.ndarray, joint: int, step: float) -> Twist:
        weight, drag, inertia = tangent.own(joint)
        load = load + self.load_shift
        if not np.min(inertia) > 0.0:  # a link that a fit left without inertia never floats
            return resting(load, 0.5 * self.gap)
        teeth = min(TEETH, 0.125 / step), self.damping_ratio
        return loose(inertia, drag, weight, load, step, 0.5 * self.gap, teeth)

    def spring(self, inertia: float) -> Spring:
        angular = 2 * np.pi * TEETH
        return Spring(inertia * angular**2, 2 * self.damping_ratio * inertia * angular, self.gap)

    def check(self, robot: Robot) -> None:
        super().check(robot)
        require("backlash", "gap", self.gap)
        require("backlash", "damping_ratio", self.damping_ratio)
