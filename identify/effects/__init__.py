"""Effects: the physics that exidyn can model, with one line in the table per effect."""

from importlib import metadata

from ..errors import EffectError
from .effect import Effect, JointEffect, MotionGradient, Parameter, Prior, Shape, shape
from .friction import (
    CoulombFriction,
    CurrentOffset,
    FrictionAsymmetry,
    NonlinearViscousFriction,
    StribeckFriction,
    ViscousFriction,
)
from .hysteresis import Hysteresis
from .joint_spring import JointSpring
from .kinematic_coupling import KinematicCoupling
from .load_dependent_friction import LoadDependentFriction
from .payload import Payload, known_parameters
from .rigid_body import RigidBody, RotorInertia
from .spring_balancer import SpringBalancer
from .temperature_dependent_friction import TemperatureDependentFriction
from .torque_curve import TorqueCurve
from .waves import PositionDependentFriction, TorqueRipple

GROUP = "exidyn.effects"
"""Entry-point group of effects; the names of entry points are used in robot files and by the diagnosis."""

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
    "torque_curve": TorqueCurve,
}


def name_of(effect: Effect) -> str:
    """Key of an effect in `EFFECTS`, or the name of its class if it is not in the table."""
    return next((name for name, kind in EFFECTS.items() if kind is type(effect)), type(effect).__name__)


def load_installed() -> None:
    """Add the effects of installed packages to `EFFECTS`, from entry points: name -> subclass of `Effect`.

    This is not done when exidyn is imported, since those packages import exidyn.

    Raises:
        EffectError: An entry point cannot be loaded, is not an effect, or has a name that is in use.
    """
    loaded: dict[str, type[Effect]] = {}
    for entry in metadata.entry_points(group=GROUP):
        existing = EFFECTS.get(entry.name) or loaded.get(entry.name)
        if existing is None:
            loaded[entry.name] = _loaded(entry)
        elif f"{existing.__module__}:{existing.__qualname__}" != entry.value:
            raise EffectError(f"{_where(entry)}: the name is taken. Give the entry point another name")
    EFFECTS.update(loaded)


def _loaded(entry: metadata.EntryPoint) -> type[Effect]:
    try:
        kind = entry.load()
    except Exception as error:  # whatever somebody else's module raises
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        raise EffectError(
            f"{_where(entry)} cannot be loaded from {entry.value}: {reason}. Repair or uninstall the package"
        ) from error
    if not (isinstance(kind, type) and issubclass(kind, Effect)):
        raise EffectError(
            f"{_where(entry)}: {entry.value} is not a subclass of exidyn.identification.effects.Effect"
        )
    return kind


def _where(entry: metadata.EntryPoint) -> str:
    package = entry.dist.name if entry.dist else "an unknown package"
    return f"effect '{entry.name}' of the package {package}"


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
