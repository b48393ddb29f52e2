"""Thermal: joints that warm up from what their motors and gears lose."""

from dataclasses import dataclass
from math import exp

import numpy as np


@dataclass(frozen=True, eq=False)
class Thermal:
    r"""First order, each joint alone: :math:`t_c \dot T = T_a + R_{th} (r i^2 + P_f) - T`.

    Attributes:
        ambient: Temperature :math:`T_a` around it, and at the start [degC].
        rise: Temperature above it per lost power :math:`R_{th}`, shape (n,) [K/W]; zero for none.
        resistance: Of the winding :math:`r`, shape (n,) [ohm].
        time_constant: :math:`t_c` [s].
    """

    ambient: float
    rise: np.ndarray
    resistance: np.ndarray
    time_constant: float = 1800.0

    @classmethod
    def constant(cls, joints: int, ambient: float = 25.0) -> "Thermal":
        """Joints that stay as warm as they are."""
        return cls(ambient, np.zeros(joints), np.zeros(joints))

    def after(
        self, temperature: np.ndarray, current: np.ndarray, friction: np.ndarray, seconds: float
    ) -> np.ndarray:
        """Temperature (n,) [degC] after some time with current [A] and lost power of friction [W]."""
        end = self.ambient + self.rise * (self.resistance * current**2 + friction)
        return end + (temperature - end) * exp(-seconds / self.time_constant)
