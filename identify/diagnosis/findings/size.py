"""Size: the torque of a finding with its interval, for findings whose parameters are not determined."""

from dataclasses import dataclass

from ...schema import Real
from ...text_table import NORMAL_95


def sign_known(value: float, std: float) -> bool:
    """Whether the 95 % interval excludes zero; without a standard deviation the sign counts as known."""
    return not abs(value) <= NORMAL_95 * std


@dataclass(frozen=True)
class Point:
    """Torque of a finding at one value of the quantity on which it depends."""

    which: str  # "smallest", "usual", "largest", "lowest", "middle" or "highest"; empty on a curve
    at: Real  # value of the quantity, in the unit of the axis
    torque: Real  # torque; positive against the motion if the axis is `braking` [N m]
    std: Real  # standard deviation of the torque, from all coefficients and shapes together [N m]


@dataclass(frozen=True)
class Size:
    """Torque of a finding on one joint, as far as the data determine it."""

    joint: int  # index of the joint that shows it best, from 0
    # Root mean square of the torque that no other parameter can absorb in a fit without the finding [N m].
    beside_rms: Real
    beside_std: Real  # standard deviation of `beside_rms` [N m]
    over: str = ""  # quantity on which the torque depends, a key of `AXES`; empty if it follows none
    # Torque at the smallest, usual (root mean square) and largest recorded value; for a signed quantity, at
    # its lowest, middle (median) and highest value.
    points: tuple[Point, ...] = ()
    curve: tuple[Point, ...] = ()  # torque over the recorded range
    change: bool = False  # whether torques are relative to the first point, which halves their intervals

    @property
    def known(self) -> bool:
        """Whether the points exclude zero."""
        most = max(self.points, key=lambda point: abs(point.torque), default=None)
        return most is not None and sign_known(most.torque, most.std)


@dataclass(frozen=True)
class LeftOut:
    """Reason why a parameter is not given."""

    beside: str = ""  # parameter with which it is correlated; empty if there is no single one
    effect: str = ""  # effect of that parameter, in the vocabulary; empty if it belongs to the same finding


OF_A_CURVE = LeftOut("all others of the curve")
"""Reason for the coefficients of a curve, which mean nothing one by one; the torque is given instead."""
