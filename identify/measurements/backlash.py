"""A gear with play: while the teeth change sides, the link floats without support from the motor."""

from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from ..arm.tangent import Tangent
from .gear import Gear, Spring
from .measurement import require
from .twist import Twist, bent, loose, resting

TEETH = 40.0
"""Resonance of a link on its teeth above which they count as rigid [Hz]: behind a low-pass of 25 Hz, their
impacts look alike; softer teeth also bend under the load."""
RATIO = 0.5
"""Damping ratio of the teeth, including the drive that they push back [-]."""


@dataclass(frozen=True)
class Backlash(Gear):
    """Play between two sides of the teeth.

    Attributes:
        gap: Full width of the play, at the joint [rad].
        damping_ratio: Damping ratio of the link on its teeth [-].
        load_shift: True load minus the load of the model [N m].
        resonance: Resonance of the link on its teeth [Hz].
    """

    gap: float
    damping_ratio: float = RATIO
    load_shift: float = 0.0
    resonance: float = TEETH

    def twist(self, tangent: Tangent, load: np.ndarray, joint: int, step: float) -> Twist:
        weight, drag, inertia = tangent.own(joint)
        load = load + self.load_shift
        if not np.min(inertia) > 0.0:  # a link without positive inertia in the fit never floats
            return resting(load, 0.5 * self.gap)
        return floating((inertia, drag, weight), load, step, self.gap, (self.resonance, self.damping_ratio))

    def spring(self, inertia: float) -> Spring:
        angular = 2 * np.pi * self.resonance
        return Spring(inertia * angular**2, 2 * self.damping_ratio * inertia * angular, self.gap)

    def check(self, robot: Robot) -> None:
        super().check(robot)
        require("backlash", "gap", self.gap)
        require("backlash", "damping_ratio", self.damping_ratio)
        require("backlash", "resonance", self.resonance)


def floating(
    link: tuple[np.ndarray, np.ndarray, np.ndarray],
    load: np.ndarray,
    step: float,
    gap: float,
    teeth: tuple[float, float],
) -> Twist:
    """Twist of a link with play of full width `gap` [rad]; soft teeth also bend under the load.

    `link` are inertia, damping and gravity stiffness of the link without its gear, each (t,), see `bent`. A
    rigid gear would transmit `load` (t,) [N m]. `teeth` are resonance [Hz] and damping ratio of the link on
    its teeth [-], and `step` is the sampling period [s].
    """
    inertia, drag, weight = link
    (resonance, ratio), on_teeth = teeth, None
    if resonance < TEETH:
        angular = 2 * np.pi * resonance
        stiffness = float(np.mean(inertia)) * angular**2
        on_teeth = bent(inertia, 2 * ratio * stiffness / angular + drag, stiffness + weight, load, step)
    teeth = min(resonance, 0.125 / step), ratio
    return loose(inertia, drag, weight, load, step, 0.5 * gap, teeth, on_teeth)
