"""Axes as a KUKA controller counts them, and joints as the robot's description does.

Joints are in radians, possibly turning the other way and from another zero; axes are in degrees. Corrections
are axes' degrees from where the arm stood.
"""

from dataclasses import dataclass

import numpy as np

from ..errors import BadSettings
from .rsi_settings import RsiSettings


@dataclass(frozen=True)
class Axes:
    """How the two are related.

    Attributes:
        sign: 1 or -1, shape (n,).
        zero: Joint's position where the axis shows zero, shape (n,) [rad].
        ampere: Amperes in the controller's unit of current, shape (n,).
    """

    sign: np.ndarray
    zero: np.ndarray
    ampere: np.ndarray

    def joints(self, degrees: np.ndarray) -> np.ndarray:
        """Positions of joints (n,) [rad] from those of axes [deg]."""
        return self.sign * np.radians(degrees) + self.zero

    def degrees(self, position: np.ndarray) -> np.ndarray:
        """Positions of axes (n,) [deg] from those of joints [rad]."""
        return self.sign * np.degrees(position - self.zero)

    def window(self, lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Limits of corrections [deg] as limits of joints' excursions, each (n,) [rad]."""
        ends = np.radians([self.sign * lower, self.sign * upper])
        return ends.min(axis=0), ends.max(axis=0)


def axes_of(settings: RsiSettings) -> Axes:
    """How axes and joints are related, as set.

    Raises:
        BadSettings: Currents in percent of nothing.
    """
    ampere = []
    for place, (unit, most) in enumerate(zip(settings.current_unit, settings.i_max, strict=True)):
        if unit == "percent" and not most:
            raise BadSettings(
                f"driver kuka_rsi: current_unit[{place}] is percent; set i_max, the current at 100 percent"
            )
        ampere.append(0.01 * most if unit == "percent" else 1.0)
    return Axes(np.array(settings.sign), np.array(settings.zero), np.array(ampere))
