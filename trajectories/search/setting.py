"""Setting and result of a search for a trajectory."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..families.fourier import Fourier
from .torque_spread import TorqueSpread


@dataclass(frozen=True, eq=False)
class Setting:
    """Constraints and shape of the trajectories to search."""

    limits: Limits  # limits, finite for position, velocity, acceleration and jerk
    harmonics: int = 12  # number of harmonics
    periods: tuple[float, ...] = (10.0,)  # base periods that the starts take in turn [s]
    clearances: Sequence[Clearance] = ()  # collisions and regions
    series: int = 1  # number of trajectories that are planned together
    tick: float = 0.002  # sampling period of the controller [s]; a base period is a multiple of it


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of one start, after the exact check."""

    series: tuple[Fourier, ...]  # the trajectories
    value: float  # value of the goal, at samples `delivery.FINE` apart
    seed: int  # seed of this start
    # Time [s] and value of each deliverable intermediate result.
    history: list[tuple[float, float]] = field(default_factory=list)
    # Uncertainty of the torque, with the factor by which the series keep to the limits.
    spread: TorqueSpread | None = None
