"""Formulas: what is found but is only the error of the formula of something greater."""

from collections.abc import Sequence

from .found import Found, competing
from .hypothesis import Hypothesis

FORMULA = 0.25
"""How wrong the formula of an effect may be, share of its torque [-]: friction laws are no better."""
FIRST_ORDER = 0.1
"""Likewise where a link's own motion is followed to first order only, where all torque comes later, which is
known no better, and of any formula on its own joint."""
ONE_OF = ({"drive_gain_saturation", "current_clipping"}, {"joint_spring", "spring_balancer"})
"""Effects of which a joint has one: a drive has one end, and one function of position pulls a joint. What one
formula leaves of it looks like the other."""
BENT = ("drive_gain_saturation", "current_clipping")
"""Effects whose formula is no better for anything else on their joint: how a drive gives way near its end is
its maker's, and what is missing there goes with load, and so with position."""
SAGGING = (*BENT, "drive_gain")
"""Effects that a drive seems to have beside a supply that sags for all: for one more than for another."""
HALVES = 0.5
"""Share of a coupled motor's own friction and inertia that may be with one of its joints or the other."""
SPREADING = ("joint_elasticity", "backlash", "time_delay", "hose_spring", "supply_sag")
"""Effects whose error is on other joints too: a link moves otherwise than its motor, and all that it carries
with it; all drives' torque comes later, or takes more current; a hose is no straight spring."""
SPLIT = ("viscous_friction", "coulomb_friction", "rotor_inertia")
"""What a motor that turns with two joints splits between them in a way that no formula knows."""
KINDS = (
    {
        "viscous_friction", "coulomb_friction", "friction_asymmetry", "stribeck_friction", "hysteresis",
        "load_dependent_friction", "nonlinear_viscous_friction", "temperature_dependent_friction",
        "position_dependent_friction",
    },
    {"spring_balancer", "joint_spring", "current_offset", "friction_asymmetry"},
    {
        "drive_gain", "drive_gain_saturation", "current_clipping", "time_delay", "joint_elasticity",
        "backlash", "torque_ripple", "hysteresis",
    },
)  # fmt: skip
"""Effects whose formulas stand in for one another: friction, springs, and what drives and gears do."""


def told_apart(found: Sequence[Found]) -> list[Found]:
    """Findings in the order of their evidence, without what is but the error of another's formula.

    No friction is quite as its formula has it. What that leaves looks like a further, smaller effect of the
    same joint.
    """
    kept: list[Found] = []
    for one in sorted(found, key=lambda one: -one.hypothesis.evidence):
        own, greater = one.hypothesis, [other.hypothesis for other in kept]
        if all(own.evidence > _error(own, other) * other.evidence for other in greater):
            kept.append(one)
    return kept


def _error(one: Hypothesis, other: Hypothesis) -> float:
    """Share of the other's evidence that one may have by being the error of the other's formula."""
    own, more = one.candidate, other.candidate
    if own.joints == more.joints and {own.effect, more.effect} in ONE_OF:
        return 1.0
    if own.joints == more.joints and more.effect in BENT:
        return FORMULA**2
    if own.joints == more.joints and any({own.effect, more.effect} <= kind for kind in KINDS):
        return FORMULA**2
    if more.effect == "supply_sag" and own.effect in SAGGING:
        return FORMULA**2
    if more.effect == "kinematic_coupling" and own.effect in SPLIT and set(own.joints) < set(more.joints):
        return HALVES**2
    if own.joints and own.joints == more.joints:
        return FIRST_ORDER**2
    return FIRST_ORDER**2 if more.effect in SPREADING and competing(one, other) else 0.0
