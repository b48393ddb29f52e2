"""Kind: what the diagnosis knows of one effect, beside its formula."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ...effects import Shape
from ...model import Model
from ..blocks.prediction import Prediction
from ..questions.block_answer import Answer
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .arm import Arm
from .family import FamilyOf
from .finding import Finding, Hypothesis

Ask = Callable[[Model], Iterator[Candidate]]
AskOfRest = Callable[[Model, Prediction, Sequence[Driven]], Iterator[Candidate]]
Measure = Callable[[Model, Prediction, Sequence[Driven]], Iterator[tuple[Answer, Answer]]]
Derive = Callable[[Finding, Mapping[str, Any]], Mapping[str, Any]]
Hold = Callable[[Arm, Hypothesis], Arm | None]


@dataclass(frozen=True)
class Kind:
    """One effect of the vocabulary, or outside; with nothing given, any effect that acts on single joints.

    The sentence of a finding has no full stop. Names in braces are its parameters, and what `derived` gives;
    text in square brackets is left out where one of them is not known. "{joint}" is the joint, "{other}" the
    second one. Without a sentence a finding is given by its name. `determined_as` names what the data know of
    a parameter where they know a product only. A shape is refined between the neighbours of those tried.
    """

    sentence: str = ""  # see above
    drawn_against: tuple[str, ...] = ()  # two axes of the report on which it shows
    family: str | FamilyOf = ""  # one of `FAMILIES`; empty for a family of its own
    formula: bool = True  # whether its torque follows a formula, and no curve that may have any form
    ask: Ask | None = None  # its hypotheses; by default, its effect on each joint
    ask_of_rest: AskOfRest | None = None  # more hypotheses, by what a prediction leaves
    ask_first: AskOfRest | None = None  # the same once, before anything was found
    measured: Measure | None = None  # found otherwise than by torque: evidence, and the effect as torque
    shapes: tuple[Mapping[str, Any], ...] = ({},)  # arguments of the effect that are tried
    bounds: Mapping[str, Shape] = field(default_factory=dict)  # of its shape, if narrower
    reducible: bool = False  # whether a model may have too much of it: below zero
    dry: bool = False  # whether it is dry friction, which changes its sign at rest
    derived: Derive | None = None  # numbers that people ask for, out of the fitted ones
    mistaken_for: tuple[str, ...] = ()  # what it is taken for most easily
    settled_by: str = ""  # the run in which it looks least like anything else
    held: Hold | None = None  # how an arm holds it, if not as an effect of the model
    gear: bool = False  # whether it is between motor and link
    sensor: bool = False  # whether it changes what is recorded of the arm, and nothing in it
    of_body: bool = False  # whether its units are those of a body, whatever its joint does
    # parameter -> name and unit of what the data know of it
    determined_as: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    remark: str = ""  # about what the data do not know, and what gives it
