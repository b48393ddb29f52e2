"""Waves along a turn: how many multiples are asked for together, and their amplitude."""

from collections.abc import Mapping
from typing import Any

from ...findings.finding import Finding
from ...findings.quantities import length

MULTIPLES = 6
"""Of a wave along a turn that are asked for together; what is sharper has little torque in those beyond."""
WAVES = ("Rcos", "Rsin", "Fcos", "Fsin")
"""Beginnings of the names of their coefficients."""


def amplitude(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Root of the sum of squares of all waves."""
    waves = [name for name in finding.parameters if name.startswith(WAVES)]
    return {"wave": length(finding.parameters, *waves)} if waves else {}
