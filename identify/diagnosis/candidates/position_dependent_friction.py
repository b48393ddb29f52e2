"""Position-dependent friction: dry friction that waves along a joint's turn."""

from collections.abc import Iterator
from dataclasses import replace

from ...effects import Effect
from ...model import Model
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from .parts.of_effect import on_each_joint
from .parts.waves import MULTIPLES, amplitude

SHARE = 0.3
"""By how much dry friction depends on position at most, share of the joint's usual torque [-]: it brakes
everywhere, so that it varies by less than its mean. Nothing else holds the waves where a joint did not go."""


def waves(model: Model) -> Iterator[Candidate]:
    """On each joint, one wave or a bump of any form, whose multiples become smaller as those of a jump do."""

    def smaller(candidate: Candidate, effect: Effect) -> Candidate:
        several = range(1, getattr(effect, "count", 1) + 1)
        each = tuple(1.0 / multiple for multiple in several for _ in range(2))
        return replace(candidate, size=SHARE, proportion=each)

    return on_each_joint(model, "position_dependent_friction", KIND, smaller)


KIND = Kind(
    sentence="{joint} has position-dependent friction: it varies by {wave}[, {pace}]",
    drawn_against=("where it brakes", "velocity"),
    ask=waves,
    shapes=(*({"harmonic": float(k)} for k in (1, 2, 3)), {"count": MULTIPLES}),
    derived=amplitude,
    mistaken_for=("load_dependent_friction", "torque_ripple"),
)
