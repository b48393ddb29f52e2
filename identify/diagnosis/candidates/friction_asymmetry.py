"""Asymmetric friction: more of it one way than the other."""

from collections.abc import Mapping
from typing import Any

from ..findings.finding import Finding
from ..findings.kind import Kind
from ..findings.quantities import TURNING, together


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """By how much one direction is above the mean; where that depends on speed, at 1 rad/s."""
    if "Fa" not in known:
        return {}
    unit = "rad" if known["Fa"].unit == TURNING else "m"
    return {
        "more": together(known, "Fa", "Fva"),
        "speed": f" at 1 {unit}/s" if "Fva" in known else "",
    }


KIND = Kind(
    sentence="{joint} has asymmetric friction: {more:forwards|backwards} it is {more:size} above the mean "
    "of both directions{speed}",
    drawn_against=("velocity", "position"),
    shapes=({}, {"viscous": True}),
    derived=_derived,
    mistaken_for=("current_offset", "joint_spring"),
    settled_by="constant speeds both ways (exidyn excite --kind sweeps)",
)
