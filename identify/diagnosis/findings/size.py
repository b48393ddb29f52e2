"""Size: what is known of a finding where its numbers are not, as torque with an interval."""

from dataclasses import dataclass
from typing import NamedTuple

from ...text_table import NORMAL_95


def sign_known(value: float, std: float) -> bool:
    """Whether zero is outside of a number's 95 % interval; a number without a deviation is as it is."""
    return not abs(value) <= NORMAL_95 * std


class Point(NamedTuple):
    """Torque of a finding where what it depends on has one value.

    Attributes:
        which: "smallest", "usual", "largest", "lowest", "middle" or "highest"; empty on a curve.
        at: That value, in the unit of the axis.
        torque: Against the motion where its axis is `braking` [N m].
        std: Its standard deviation, of all coefficients and shapes together [N m].
    """

    which: str
    at: float
    torque: float
    std: float


@dataclass(frozen=True)
class Size:
    """Torque of a finding on one joint, with what the data know of it.

    Attributes:
        joint: On which it shows best, from 0.
        beside: Root mean square of what it gives that no other parameter can take over, fitted anew without
            it, and its standard deviation [N m].
        over: What its torque depends on, a key of `AXES`; empty where it follows nothing recorded.
        points: At the smallest recorded, usual (root mean square) and largest; of what has a sign, at its
            lowest, middle (median) and highest.
        curve: Over all that was recorded.
        change: Whether torques are less that of the first point, by which their intervals are half as wide.
    """

    joint: int
    beside: tuple[float, float]
    over: str = ""
    points: tuple[Point, ...] = ()
    curve: tuple[Point, ...] = ()
    change: bool = False

    @property
    def known(self) -> bool:
        """Whether the points say more than zero."""
        most = max(self.points, key=lambda one: abs(one.torque), default=None)
        return most is not None and sign_known(most.torque, most.std)


class LeftOut(NamedTuple):
    """Why a number is not given.

    Attributes:
        beside: The parameter that changes with it; empty where there is no one such.
        effect: What that is a parameter of, in the vocabulary; empty where it is of the same finding.
    """

    beside: str = ""
    effect: str = ""


OF_A_CURVE = LeftOut("all others of the curve")
"""Coefficients of a curve say nothing one by one: its torque is given."""
