"""Setting: within what a trajectory is searched; and what a search found."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..families.fourier import Fourier
from .torque_spread import TorqueSpread


@dataclass(frozen=True, eq=False)
class Setting:
    """Within what to search.

    Attributes:
        limits: Finite ones of position, velocity, acceleration and jerk.
        harmonics: Number of harmonics.
        periods: Base periods that the starts take in turn [s].
        clearances: Collisions and regions.
        series: How many trajectories are planned together.
        tick: Tick of the controller [s]; a period is a whole number of them.
    """

    limits: Limits
    harmonics: int = 12
    periods: tuple[float, ...] = (10.0,)
    clearances: Sequence[Clearance] = ()
    series: int = 1
    tick: float = 0.002


@dataclass(frozen=True, eq=False)
class Found:
    """What one start came to, after the exact check.

    Attributes:
        series: The trajectories.
        value: Value of the goal, at samples `delivery.FINE` apart.
        seed: Seed of this start.
        history: Seconds and value of the goal as it would have been delivered, as the search went on.
        spread: What is not known of the torque, with the factor by which the series keep to the limits.
    """

    series: tuple[Fourier, ...]
    value: float
    seed: int
    history: list[tuple[float, float]] = field(default_factory=list)
    spread: TorqueSpread | None = None
