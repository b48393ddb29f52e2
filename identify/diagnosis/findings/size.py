"""Size: the torque of a finding with its interval, for findings whose parameters are not determined."""

from dataclasses import dataclass

from ...schema import Real
from ...text_table import NORMAL_95


def sign_known(value: float, std: float) -> bool:
    """Whether the 95 % interval excludes zero; without a standard deviation the sign counts as known."""
    return not abs(value) <= NORMAL_95 * std


@dataclass(frozen=True)
class Point:
    """Torque of a finding at one value of the quantity on which it depends.

    Attributes:
        which: "smallest", "usual", "largest", "lowest", "middle" or "highest"; empty on a curve.
        at: Value of the quantity, in the unit of the axis.
        torque: Torque; positive against the motion if the axis is `braking` [N m].
        std: Standard deviation of the torque, from all coefficients and shapes together [N m].
    """

    which: str
    at: Real
    torque: Real
    std: Real


@dataclass(frozen=True)
class Size:
    """Torque of a finding on one joint, as far as the data determine it.

    Attributes:
        joint: Index of the joint that shows it best, from 0.
        beside_rms: Root mean square of the torque that no other parameter can absorb in a fit without the
            finding [N m].
        beside_std: Standard deviation of `beside_rms` [N m].
        over: Quantity on which the torque depends, a key of `AXES`; empty if it follows none.
        points: Torque at the smallest, usual (root mean square) and largest recorded value; for a signed
            quantity, at its lowest, middle (median) and highest value.
        curve: Torque over the recorded range.
        change: Whether torques are relative to the first point, which halves their intervals.
    """

    joint: int
    beside_rms: Real
    beside_std: Real
    over: str = ""
    points: tuple[Point, ...] = ()
    curve: tuple[Point, ...] = ()
    change: bool = False

    @property
    def known(self) -> bool:
        """Whether the points exclude zero."""
        most = max(self.points, key=lambda point: abs(point.torque), default=None)
        return most is not None and sign_known(most.torque, most.std)


@dataclass(frozen=True)
class LeftOut:
    """Reason why a parameter is not given.

    Attributes:
        beside: Parameter with which it is correlated; empty if there is no single one.
        effect: Effect of that parameter, in the vocabulary; empty if it belongs to the same finding.
    """

    beside: str = ""
    effect: str = ""


OF_A_CURVE = LeftOut("all others of the curve")
"""Reason for the coefficients of a curve, which mean nothing one by one; the torque is given instead."""
