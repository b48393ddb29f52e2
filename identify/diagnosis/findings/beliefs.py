"""Beliefs: the bodies as described, and free bodies; where the two lead to different findings."""

from dataclasses import dataclass

import numpy as np

from ...schema import Count, Real


@dataclass(frozen=True)
class Departure:
    """A group of nominal parameters that leaves its stated tolerance, such as a link, a gain or the base."""

    group: str  # "link", "rotor" or "drive gain"
    joint: int  # joint of the group, from 0
    parameter: str  # parameter that deviates most, such as "MX2"
    deviations: Real  # its change over its stated standard deviation [-]
    nominal: Real  # nominal value, in the unit of the parameter
    value: Real  # fitted value
    unit: str


@dataclass(frozen=True, eq=False)
class Beliefs:
    """Findings with the bodies as described, beside those with free bodies.

    The model of the diagnosis has the bodies within their tolerances. Free bodies can absorb a torque that
    depends on position and acceleration, so a finding may be needed with one belief and not with the other.
    """

    # Indices of findings, undecided ones behind the others, that free bodies absorb.
    conditional: tuple[Count, ...]
    # Bodies that leave their tolerance if they are free and the conditional findings are left out.
    absorbed_by: tuple[Departure, ...]
    # Parameters that leave their tolerance in the model of the diagnosis, with all findings.
    departures: tuple[Departure, ...]
    # Held-out residual with bodies as described and all findings, shape (n,) [N m]; that of left-out blocks
    # without held-out runs.
    described_rms: np.ndarray
    # Held-out residual with free bodies and without the conditional findings, shape (n,) [N m].
    free_rms: np.ndarray
