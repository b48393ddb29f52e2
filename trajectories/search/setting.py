"""Setting and result of a search for a trajectory."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..families.fourier import Fourier
from .torque_spread import TorqueSpread


@dataclass(frozen=True, eq=False)
class Setting:
    """Constraints and shape of the trajectories to search.

    Attributes:
        limits: Limits, finite for position, velocity, acceleration and jerk.
        harmonics: Number of harmonics.
        periods: Base periods that the starts take in turn [s].
        clearances: Collisions and regions.
        series: Number of trajectories that are planned together.
        tick: Sampling period of the controller [s]; a base period is a multiple of it.
    """

    limits: Limits
    harmonics: int = 12
    periods: tuple[float, ...] = (10.0,)
    clearances: Sequence[Clearance] = ()
    series: int = 1
    tick: float = 0.002


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of one start, after the exact check.

    Attributes:
        series: The trajectories.
        value: Value of the goal, at samples `delivery.FINE` apart.
        seed: Seed of this start.
        history: Time [s] and value of each deliverable intermediate result.
        spread: Uncertainty of the torque, with the factor by which the series keep to the limits.
    """

    series: tuple[Fourier, ...]
    value: float
    seed: int
    history: list[tuple[float, float]] = field(default_factory=list)
    spread: TorqueSpread | None = None
