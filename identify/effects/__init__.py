"""The list of physics that exidyn knows: one file an effect, one line in this table."""

from .coulomb_friction import CoulombFriction
from .current_offset import CurrentOffset
from .effect import Effect, JointEffect, MotionGradient, Parameter, Prior, Shape, shape
from .friction_asymmetry import FrictionAsymmetry
from .hysteresis import Hysteresis
from .installed import installed
from .joint_spring import JointSpring
from .kinematic_coupling import KinematicCoupling
from .load_dependent_friction import LoadDependentFriction
from .nonlinear_viscous_friction import NonlinearViscousFriction
from .payload import Payload, known_parameters
from .position_dependent_friction import PositionDependentFriction
from .rigid_body import RigidBody
from .rotor_inertia import RotorInertia
from .spring_balancer import SpringBalancer
from .stribeck_friction import StribeckFriction
from .temperature_dependent_friction import TemperatureDependentFriction
from .torque_ripple import TorqueRipple
from .viscous_friction import ViscousFriction

EFFECTS: dict[str, type[Effect]] = {
    "link_inertia": RigidBody,
    "rotor_inertia": RotorInertia,
    "viscous_friction": ViscousFriction,
    "coulomb_friction": CoulombFriction,
    "current_offset": CurrentOffset,
    "payload": Payload,
    "friction_asymmetry": FrictionAsymmetry,
    "stribeck_friction": StribeckFriction,
    "hysteresis": Hysteresis,
    "load_dependent_friction": LoadDependentFriction,
    "nonlinear_viscous_friction": NonlinearViscousFriction,
    "temperature_dependent_friction": TemperatureDependentFriction,
    "position_dependent_friction": PositionDependentFriction,
    "spring_balancer": SpringBalancer,
    "joint_spring": JointSpring,
    "torque_ripple": TorqueRipple,
    "kinematic_coupling": KinematicCoupling,
}


def name_of(effect: Effect) -> str:
    """Key of an effect in `EFFECTS`; the class's name where it is not in there."""
    return next((name for name, kind in EFFECTS.items() if kind is type(effect)), type(effect).__name__)


def load_installed() -> None:
    """Add the effects of installed packages to `EFFECTS`; the table stays as it is where there are none.

    Not when this package is imported: theirs import it.

    Raises:
        EffectError: One of them cannot be loaded.
    """
    EFFECTS.update(installed(EFFECTS))


__all__ = [
    "EFFECTS",
    "Prior",
    "Effect",
    "JointEffect",
    "MotionGradient",
    "Parameter",
    "Shape",
    "known_parameters",
    "load_installed",
    "name_of",
    "shape",
    *sorted(effect.__name__ for effect in EFFECTS.values()),
]
