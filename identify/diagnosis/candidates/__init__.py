"""The vocabulary: what may be missing, one file each.

A file NAME.py holds everything about the effect of that name: hypotheses, shapes, priors, its sentence, what
it is mistaken for and which run settles it. An effect without a file is asked for on each joint, if it acts
on single joints: whatever is in `EFFECTS`.
"""

from collections.abc import Iterator
from importlib import import_module

from ...effects import EFFECTS, load_installed
from ...model import Model
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from .parts.of_effect import on_each_joint, on_single_joints

FILES = (
    "axis_misalignment",
    "backlash",
    "base_tilt",
    "contact_event",
    "coulomb_friction",
    "current_clipping",
    "current_crosstalk",
    "current_offset",
    "drive_gain",
    "drive_gain_saturation",
    "encoder_offset",
    "friction_asymmetry",
    "hose_spring",
    "hysteresis",
    "joint_elasticity",
    "joint_spring",
    "kinematic_coupling",
    "link_inertia",
    "load_dependent_friction",
    "neighbour_friction",
    "nonlinear_viscous_friction",
    "payload",
    "position_dependent_friction",
    "rotor_inertia",
    "spring_balancer",
    "stribeck_friction",
    "supply_sag",
    "temperature_dependent_friction",
    "time_delay",
    "torque_ripple",
    "viscous_friction",
)
"""One each, in this folder."""

KINDS: dict[str, Kind] = {name: import_module(f".{name}", __name__).KIND for name in FILES}
"""Name -> what is known of it; also of what has no name in the vocabulary."""


def kind_of(effect: str) -> Kind:
    """What is known of an effect; nothing in particular of one without a file."""
    return KINDS.get(effect, Kind())


def kinds() -> dict[str, Kind]:
    """Of everything that is asked for, effects of installed packages included.

    Raises:
        EffectError: An installed package has an effect that cannot be loaded.
    """
    load_installed()
    single = [name for name, effect in EFFECTS.items() if on_single_joints(effect)]
    return KINDS | {name: kind_of(name) for name in single}


def hypotheses(effect: str, model: Model) -> Iterator[Candidate]:
    """Of one effect, every joint and shape."""
    kind = kind_of(effect)
    return on_each_joint(model, effect, kind) if kind.ask is None else kind.ask(model)


def candidates(model: Model) -> Iterator[Candidate]:
    """All hypotheses, also of what has no name in the vocabulary."""
    for effect in kinds():
        yield from hypotheses(effect, model)
