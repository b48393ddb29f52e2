"""Temperature-dependent friction: viscous and dry friction that change as a joint warms."""

from collections.abc import Mapping
from typing import Any

from ..findings.finding import Finding
from ..findings.kind import Kind
from ..findings.quantities import together


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Whether friction rises, dry and viscous together at 1 rad/s."""
    return {"warm": together(known, "Fvt", "Fct")} if "Fvt" in known else {}


KIND = Kind(
    sentence="{joint} has friction that {warm:rises|falls} with temperature: viscous friction changes by "
    "{Fvt}[ and Coulomb friction by {Fct}]",
    drawn_against=("temperature", "time"),
    derived=_derived,
    mistaken_for=("viscous_friction", "nonlinear_viscous_friction"),
    settled_by="the same run again once the arm is warm",
)
