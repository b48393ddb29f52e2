"""A smooth curve of torque over one quantity, for torque that does not follow a formula."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import JointEffect, Parameter
from .smooth_sign import smooth_sign

SPLINES = 6
"""Number of cubic splines in a curve: enough for a decrease at low speed, a bend and a slope."""
DENSE = 0.03
"""Share of the highest speed or load below which splines are spaced evenly, and above it by ratios [-]."""


class Abscissa(NamedTuple):
    """Abscissa of a curve."""

    letter: str  # letter in the names of parameters
    values: Callable[[Motion], np.ndarray]  # function that returns the abscissa along a motion, shape (t, n)
    braking: bool  # whether the torque opposes the motion, as friction does
    size: bool  # whether the abscissa is a magnitude, with highest resolution at small values


ABSCISSAE: Mapping[str, Abscissa] = {
    "velocity": Abscissa("v", lambda motion: np.abs(motion.velocity), braking=True, size=True),
    "direction": Abscissa("d", lambda motion: np.abs(motion.velocity), braking=False, size=True),
    "load": Abscissa("l", lambda motion: np.abs(motion.load), braking=True, size=True),
    "position": Abscissa("q", lambda motion: motion.position, braking=False, size=False),
    "position and direction": Abscissa("b", lambda motion: motion.position, braking=True, size=False),
}
"""Name -> abscissa."""


@dataclass(frozen=True)
class TorqueCurve(JointEffect):
    r"""Torque :math:`\sum_k C_k B_k(x)` of cubic B-splines, times the direction of motion for friction.

    Over speed and load, the splines are denser near zero: evenly spaced in :math:`\operatorname{arsinh} x`.
    Outside its range, the curve is constant.

    Attributes:
        over: Quantity on which the torque depends, a name in `ABSCISSAE`.
        low: Smallest value of the quantity in the runs [rad]; 0 for speed and load.
        high: Largest value of the quantity in the runs [rad], [rad/s] or [N m].
    """

    over: str = "position"
    low: float = 0.0
    high: float = 1.0

    def __post_init__(self) -> None:
        if self.over not in ABSCISSAE:
            raise ValueError(f"over = {self.over!r}: expected one of {', '.join(ABSCISSAE)}")

    @property
    def count(self) -> int:
        """Number of splines in each joint's curve."""
        return SPLINES

    @property
    def needs_load(self) -> bool:  # type: ignore[override]
        """Whether the curve is over the load."""
        return self.over == "load"

    def parameters(self, robot: Robot) -> list[Parameter]:
        letter = ABSCISSAE[self.over].letter
        return self.on_each(robot, *((f"C{letter}{k}_", "N m") for k in range(1, SPLINES + 1)))

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        over = ABSCISSAE[self.over]
        sign = smooth_sign(motion.velocity)[..., None] if over.braking else 1.0
        profiles = np.moveaxis(sign * self._splines(over, over.values(motion)), -1, 0)
        return self.on_joints(robot, *profiles)

    def _splines(self, over: Abscissa, values: np.ndarray) -> np.ndarray:
        """Splines (t, n, SPLINES) at values (t, n); they add up to one."""
        low, high = self.low, max(self.high, self.low + 1e-9)
        if over.size:
            values, low, high = np.arcsinh(values / (DENSE * high)), 0.0, float(np.arcsinh(1.0 / DENSE))
        pieces = np.clip((values - low) / (high - low), 0.0, 1.0) * PIECES
        piece = np.minimum(pieces.astype(int), PIECES - 1)
        powers = (pieces - piece)[..., None] ** np.arange(4)
        return np.einsum("...k,...ks->...s", powers, _polynomials()[piece])


@cache
def _polynomials() -> np.ndarray:
    """Coefficients of all splines in powers of the position within each piece, (PIECES, 4, SPLINES).

    The recursion of Cox and de Boor is evaluated at four points of each piece and interpolated by a cubic.
    Simulations evaluate a curve at every time step, and SciPy takes several times as long.
    """
    knots = np.concatenate([[0.0] * 3, np.arange(PIECES + 1.0), [float(PIECES)] * 3])
    places = np.array([0.0, 0.25, 0.5, 0.75])
    x = (np.arange(PIECES)[:, None] + places)[..., None]
    basis = ((knots[:-1] <= x) & (x < knots[1:])).astype(float)
    for degree in range(1, 4):
        width = knots[degree:] - knots[:-degree]
        share = np.divide(
            x - knots[:-degree], width, out=np.zeros((*x.shape[:2], len(width))), where=width > 0
        )
        basis = share[..., :-1] * basis[..., :-1] + (1.0 - share[..., 1:]) * basis[..., 1:] * (width[1:] > 0)
    return np.linalg.solve(places[:, None] ** np.arange(4), basis)


PIECES = SPLINES - 3
"""Number of cubic pieces in a curve."""
