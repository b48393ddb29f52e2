"""Joint spring: a cable or hose along a joint."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...effects import Effect
from ...fit.warnings.verdict import NORMAL_95
from ...model import Model
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..findings.quantities import Formatted
from ..questions.candidate import Candidate
from .parts.of_effect import on_each_joint

CABLE = 0.1
"""Torque of a hose or a cable, share of a joint's usual one [-]; what carries weight is a balancer."""
TURN = 2 * np.pi
"""Interval from which on a joint's angle may be any [rad]."""


def cables(model: Model) -> Iterator[Candidate]:
    """On each joint, with constant stiffness or stiffening as it stretches."""

    def weak(candidate: Candidate, effect: Effect) -> Candidate:
        return replace(candidate, cancels=True, size=CABLE)

    return on_each_joint(model, "joint_spring", KIND, weak)


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Its stiffness and where it is relaxed; its torque where it has no one stiffness."""
    if "Kc" in known:
        return {"stiffer": f"{np.max(finding.torque, initial=0.0):.3g}"}
    found = {"spring": known["Ks"]} if "Ks" in known else {}
    if "Ts" in known and "Ks" in known and known["Ks"].value > 0:
        stiffness, torque = known["Ks"].value, known["Ts"]
        ease = Formatted(-torque.value / stiffness, torque.std / stiffness, "rad")
        # Beside an offset that is free too the runs may know nothing of it.
        found |= {"ease": ease} if NORMAL_95 * ease.std < TURN else {}
    return found


KIND = Kind(
    sentence="{joint} has a spring that the model does not have, as cables and hoses make[: {spring}][, "
    "relaxed at {ease}][: it gives {stiffer} {effort}, root mean square, and stiffens as it "
    "stretches]",
    drawn_against=("position", "load"),
    ask=cables,
    shapes=({}, {"stiffening": True}),
    derived=_derived,
    mistaken_for=("friction_asymmetry", "spring_balancer"),
)
