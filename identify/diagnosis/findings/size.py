"""Size: the torque of a finding with its interval, for findings whose parameters are not determined."""

from dataclasses import dataclass

from ...schema import Real
from ...text_table import NORMAL_95


def sign_known(value: float, std: float) -> bool:
    """Whether zero is outside of a number's 95 % interval; a number without a deviation is as it is."""
    return not abs(value) <= NORMAL_95 * std


@dataclass(frozen=True)
class Point:
    """Torque of a finding at one value of the quantity that it depends on.

    Attributes:
        which: "smallest", "usual", "largest", "lowest", "middle" or "highest"; empty on a curve.
        at: That value, in the unit of the axis.
        torque: Torque; against the motion where its axis is `braking` [N m].
        std: Its standard deviation, of all coefficients and shapes together [N m].
    """

    which: str
    at: Real
    torque: Real
    std: Real


@dataclass(frozen=True)
class Size:
    """Torque of a finding on one joint, as far as the data determine it.

    Attributes:
        joint: Joint that shows it best, from 0.
        beside_rms: Root mean square of the torque that no other parameter can take over, fitted anew without
            the finding [N m].
        beside_std: Its standard deviation [N m].
        over: What its torque depends on, a key of `AXES`; empty where it follows nothing recorded.
        points: At the smallest, usual (root mean square) and largest recorded value; of a signed quantity at
            its lowest, middle (median) and highest.
        curve: Over all that was recorded.
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
    """Why a number is not given.

    Attributes:
        beside: The parameter that changes together with it; empty where no single one does.
        effect: The effect of that parameter, in the vocabulary; empty where it is of the same finding.
    """

    beside: str = ""
    effect: str = ""


OF_A_CURVE = LeftOut("all others of the curve")
"""Coefficients of a curve say nothing one by one: its torque is given."""
