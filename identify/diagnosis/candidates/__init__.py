"""The vocabulary: what may be missing.

`KINDS` of a file holds everything about the effects in it: hypotheses, shapes, priors, sentence, what each is
mistaken for and which run settles it. An effect of `EFFECTS` that is in no file is asked for on each joint,
if it acts on single joints.
"""

from collections.abc import Iterator
from importlib import import_module

from ...effects import EFFECTS, load_installed
from ...model import Model
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from .parts import on_each_joint, on_single_joints

FILES = (
    "backlash",
    "base_tilt",
    "bodies",
    "contact_event",
    "curves",
    "disturbance",
    "drives",
    "friction",
    "joint_elasticity",
    "kinematic_coupling",
    "kinematics",
    "springs",
    "time_delay",
    "torque_ripple",
)
"""Files in this folder, each with `KINDS`."""

KINDS: dict[str, Kind] = {
    name: kind for file in FILES for name, kind in import_module(f".{file}", __name__).KINDS.items()
}
"""Name -> what is known of it; also of what has no name in the vocabulary."""


def kind_of(effect: str) -> Kind:
    """What is known of an effect; nothing in particular of one in no file."""
    return KINDS.get(effect, Kind())


def family_of(candidate: Candidate) -> str:
    """Name of the family of a candidate, by its shape where that decides; empty for a family of its own."""
    family = kind_of(candidate.effect).family
    return family(candidate) if callable(family) else family


def kinds() -> dict[str, Kind]:
    """Kinds of everything that is asked for, effects of installed packages included.

    Raises:
        EffectError: An installed package has an effect that cannot be loaded.
    """
    load_installed()
    single = [name for name, effect in EFFECTS.items() if on_single_joints(effect)]
    return KINDS | {name: kind_of(name) for name in single}


def hypotheses(effect: str, model: Model) -> Iterator[Candidate]:
    """Candidates of one effect, on every joint and in every shape."""
    kind = kind_of(effect)
    return on_each_joint(model, effect, kind) if kind.ask is None else kind.ask(model)


def candidates(model: Model) -> Iterator[Candidate]:
    """All hypotheses, also of what has no name in the vocabulary."""
    for effect in kinds():
        yield from hypotheses(effect, model)
