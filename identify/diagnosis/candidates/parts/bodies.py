"""Bodies: the ten inertial parameters as candidates have them, and where a body has its mass."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ....fit.warnings.verdict import NORMAL_95
from ...findings.finding import Finding
from ...findings.quantities import Formatted

SIZE = 0.2
"""How far from its frame the mass of a body is expected to be [m]; evidence depends on its logarithm."""
PARTS = ("M", "MX", "MY", "MZ", "XX", "XY", "XZ", "YY", "YZ", "ZZ")
UNITS = ("kg", *("kg m",) * 3, *("kg m^2",) * 6)
PROPORTION = (1.0, *(SIZE,) * 3, *(SIZE**2,) * 6)


def centre(finding: Finding, known: Mapping[str, Any]) -> dict[str, str]:
    """Where its mass is, if that was found."""
    if not {"M", "MX", "MY", "MZ"} <= set(known):
        return {}
    return _body(known["M"], [known[f"M{axis}"] for axis in "XYZ"])


def _body(mass: Formatted, moments: Sequence[Formatted]) -> dict[str, str]:
    """Where a body has its mass; only its moments where the mass itself is not distinguished from zero."""
    values = np.array([moment.value for moment in moments])
    shift = "({:.3g}, {:.3g}, {:.3g})".format(*values)
    if not mass.value > NORMAL_95 * mass.std:
        return {"moments": shift, "shift": shift}
    return {"centre": "({:.0f}, {:.0f}, {:.0f})".format(*(1e3 * values / mass.value)), "shift": shift}
