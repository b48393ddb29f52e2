"""Kind: what the diagnosis knows of one effect, beside its formula."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ...effects import Shape
from ...model import Model
from ...recordings.recording import Recording
from ..blocks.prediction import Prediction
from ..questions.block_answer import Answer
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .arm import Arm
from .finding import Finding

Ask = Callable[[Model], Iterator[Candidate]]
AskOfRest = Callable[[Model, Prediction, Sequence[Driven]], Iterator[Candidate]]
Measure = Callable[[Model, Prediction, Sequence[Driven]], Iterator[tuple[Answer, Answer]]]
Derive = Callable[[Finding, Mapping[str, Any]], Mapping[str, Any]]
Hold = Callable[[Arm, Finding], Arm | None]


class Undo(NamedTuple):
    """How a fault of a recording is taken back before it is fitted.

    Attributes:
        undone: The recording without it.
        words: What was done, for a warning of the fit.
    """

    undone: Callable[[Recording, Finding], Recording]
    words: str


@dataclass(frozen=True)
class Kind:
    """One effect of the vocabulary, or outside; with nothing given, any effect that acts on single joints.

    Attributes:
        sentence: Sentence of a finding, without a full stop. Names in braces are its parameters, and what
            `derived` gives; text in square brackets is left out where one of them is not known.
            "{joint}" is the joint, "{other}" the second one. By its name where it is empty.
        drawn_against: What its residual shows most against, two axes of the report.
        ask: Its hypotheses for a model; by default, the effect of its name on each joint in each shape.
        ask_of_rest: More hypotheses, by what the prediction leaves.
        ask_first: The same once, before anything was found.
        measured: Effects that were measured otherwise than by torque: how credible that makes each, and the
            effect among the columns of torque.
        shapes: Arguments of the effect that are tried; each within half a step of any other is refined.
        bounds: Of the numbers of its shape, where they are narrower than the effect's own.
        reducible: Whether a model may have too much of it, so that a coefficient may be below zero.
        dry: Whether it is dry friction, which changes its sign at rest in some way.
        derived: Numbers that people ask for, out of those that were fitted.
        mistaken_for: What it is taken for most easily, so that people ask whether it is that.
        settled_by: The run in which it looks least like anything else.
        held: How an arm holds it in simulation, where it is no effect of a model's own kind.
        gear: Whether it is between motor and link: a simulation can have it, a model cannot.
        sensor: Whether it changes what is recorded of the arm and nothing in it.
        undo: How it is taken back out of a recording, where that can be done before a fit.
        of_body: Whether its units are those of a body, whatever its joint does.
        determined_as: Parameter -> name and unit of what the data know of it, where they know a product only.
        remark: Sentence about what they do not know, and what gives it.
    """

    sentence: str = ""
    drawn_against: tuple[str, ...] = ()
    ask: Ask | None = None
    ask_of_rest: AskOfRest | None = None
    ask_first: AskOfRest | None = None
    measured: Measure | None = None
    shapes: tuple[Mapping[str, Any], ...] = ({},)
    bounds: Mapping[str, Shape] = field(default_factory=dict)
    reducible: bool = False
    dry: bool = False
    derived: Derive | None = None
    mistaken_for: tuple[str, ...] = ()
    settled_by: str = ""
    held: Hold | None = None
    gear: bool = False
    sensor: bool = False
    undo: Undo | None = None
    of_body: bool = False
    determined_as: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    remark: str = ""
