"""The list of physics that exidyn knows: one file an effect, one line in this table."""

from .coulomb_friction import CoulombFriction
from .current_offset import CurrentOffset
from .effect import Belief, Effect, JointEffect, Parameter, Shape, shape
from .rigid_body import RigidBody
from .rotor_inertia import RotorInertia
from .viscous_friction import ViscousFriction

EFFECTS: dict[str, type[Effect]] = {
    "link_inertia": RigidBody,
    "rotor_inertia": RotorInertia,
    "viscous_friction": ViscousFriction,
    "coulomb_friction": CoulombFriction,
    "current_offset": CurrentOffset,
}

__all__ = ["EFFECTS", "Belief", "Effect", "JointEffect", "Parameter", "Shape", "shape", *sorted(
    effect.__name__ for effect in EFFECTS.values()
)]
