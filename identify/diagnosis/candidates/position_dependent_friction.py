"""Position-dependent friction: dry friction that waves along a joint's turn."""

from ..findings.kind import Kind
from .parts.waves import MULTIPLES, amplitude

KIND = Kind(
    sentence="{joint} has position-dependent friction: it varies by {wave}[, {pace}]",
    drawn_against=("where it brakes", "velocity"),
    shapes=(*({"harmonic": float(k)} for k in (1, 2, 3)), {"count": MULTIPLES}),
    derived=amplitude,
    mistaken_for=("load_dependent_friction", "torque_ripple"),
)
