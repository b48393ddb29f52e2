"""Kind: properties of one effect that the diagnosis uses, in addition to its formula."""

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
    """Properties of one effect; the defaults hold for any effect that acts on single joints.

    The sentence of a finding has no full stop. Names in braces are parameters and results of `derived`; text
    in square brackets is left out if one of its names is unknown. "{joint}" is the joint and "{other}" the
    second joint. Without a sentence, a finding is given by its name. If the data determine only a product,
    `determined_as` names that product. A shape is refined between the neighbors of the tried shapes.
    """

    sentence: str = ""  # see above
    drawn_against: tuple[str, ...] = ()  # two axes of the report on which it shows
    family: str | FamilyOf = ""  # one of `FAMILIES`; empty for a family of its own
    formula: bool = True  # whether its torque follows a formula instead of a free curve
    ask: Ask | None = None  # its hypotheses; by default, the effect on each joint
    ask_of_rest: AskOfRest | None = None  # more hypotheses, derived from the residual of a prediction
    ask_first: AskOfRest | None = None  # hypotheses from the residual before any finding
    measured: Measure | None = None  # evidence from other signals, and the effect as torque
    shapes: tuple[Mapping[str, Any], ...] = ({},)  # arguments of the effect that are tried
    bounds: Mapping[str, Shape] = field(default_factory=dict)  # bounds of its shape, if others
    reducible: bool = False  # whether its parameters may be negative: the model has too much of it
    dry: bool = False  # whether it is dry friction, which changes its sign at rest
    derived: Derive | None = None  # numbers for the sentence, computed from the fitted ones
    settled_by: str = ""  # the run in which it looks least like anything else
    held: Hold | None = None  # how an arm represents it, if not as an effect of the model
    gear: bool = False  # whether it acts between motor and link
    sensor: bool = False  # whether it changes only the recorded signals, not the arm
    of_body: bool = False  # whether its units are those of a body, for any kind of joint
    # name and unit of the quantity that the data determine, by parameter
    determined_as: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    remark: str = ""  # on what the data do not determine, and how to determine it
