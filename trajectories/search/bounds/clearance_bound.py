"""Clearances (self-collision, region) as bounds of an optimiser."""

from dataclasses import dataclass

from ...clearances.clearance import Clearance
from ...trajectory import States
from .kinematic_bounds import Bound, Margins

SCALE = 0.1
"""Distance that counts like the whole range of a joint [m]: about a link's thickness."""


@dataclass(frozen=True, eq=False)
class ClearanceBound(Bound):
    """Margins of a clearance at every sample."""

    clearance: Clearance

    def margins(self, states: States) -> Margins:
        value, slope = self.clearance.gradient(states.position)
        return Margins(value / SCALE, lambda: (slope / SCALE, None, None, None))
