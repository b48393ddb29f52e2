"""The vocabulary: effects that a model may lack.

`KINDS` of a file holds everything about its effects: hypotheses, shapes, priors, sentence, and the run that
shows each best. An effect of `EFFECTS` that is in no file is tested on each joint, if
it acts on single joints.
"""

from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules

from ...effects import EFFECTS, load_installed
from ...model import Model
from ..findings.family import FAMILIES
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from .parts import on_each_joint, on_single_joints

KINDS: dict[str, Kind] = {
    name: kind
    for file in iter_modules(__path__)
    for name, kind in getattr(import_module(f".{file.name}", __name__), "KINDS", {}).items()
}
"""Name -> kind, of all files in this folder, including effects that are not listed in the vocabulary."""


def kind_of(effect: str) -> Kind:
    """Kind of an effect; the default kind for an effect that is in no file."""
    return KINDS.get(effect, Kind())


def family_of(candidate: Candidate) -> str:
    """Name of a candidate's family, which may depend on its shape; empty without a family."""
    family = kind_of(candidate.effect).family
    return family(candidate) if callable(family) else family


def dependence_of(candidate: Candidate) -> str:
    """Quantity on which the torque of a candidate depends; empty without a family."""
    family = family_of(candidate)
    return FAMILIES[family].dependence if family else ""


def kinds() -> dict[str, Kind]:
    """Kinds of all effects that are tested, including effects of installed packages.

    Raises:
        EffectError: If an effect of an installed package cannot be loaded.
    """
    load_installed()
    single = [name for name, effect in EFFECTS.items() if on_single_joints(effect)]
    return KINDS | {name: kind_of(name) for name in single}


def hypotheses(effect: str, model: Model) -> Iterator[Candidate]:
    """Candidates of one effect, on every joint and in every shape."""
    kind = kind_of(effect)
    return on_each_joint(model, effect, kind) if kind.ask is None else kind.ask(model)


def candidates(model: Model) -> Iterator[Candidate]:
    """Candidates of all effects, including unlisted ones."""
    for effect in kinds():
        yield from hypotheses(effect, model)
