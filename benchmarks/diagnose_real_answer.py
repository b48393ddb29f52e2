"""What diagnosis says of a real arm when something it is known to have is taken out of the belief."""

from functools import cache
from typing import NamedTuple

import numpy as np
from diagnose_real_arms import ARMS, Asked
from diagnose_real_belief import NAMES, believe, without
from exidyn.identify.diagnosis.diagnose import diagnose
from exidyn.identify.diagnosis.finding import Diagnosis
from exidyn.identify.diagnosis.runs import HELD_OUT
from exidyn.identify.model import Model

AKIN = {
    "coulomb_friction": ("hysteresis", "stribeck_friction", "nonlinear_viscous_friction"),
    "viscous_friction": ("nonlinear_viscous_friction",),
    "rotor_inertia": ("link_inertia",),
    "payload": ("link_inertia",),
}
"""What is right as well: dry friction that bends before it slides or fades with speed, friction that grows
with a lower power of speed, as that of real gears does; a link that is heavier by what a rotor, or a body on
the flange, would be."""

PARTS = {"coulomb_friction": ("coulomb_friction", "hysteresis")}
"""Dry friction that slides and dry friction that bends first are parts of one whole."""


class Question(NamedTuple):
    """A belief with something taken out, and the runs to be asked.

    Attributes:
        arm: Key of `ARMS`.
        asked: Runs.
        effect: What is taken out; empty for nothing.
        joint: Where, from 0; -1 for a payload.
        known: Run and mass [kg] of the body that gave the drive gains.
        mass: Of the payload that is hidden [kg].
        drawn: Whether the links are believed to be as drawn.
    """

    arm: str
    asked: Asked
    effect: str = ""
    joint: int = -1
    known: tuple[str, float] | None = None
    mass: float = float("nan")
    drawn: bool = False

    @property
    def place(self) -> tuple[str, tuple[int, ...]]:
        """Effect and joints, as a finding has them."""
        return self.effect, () if self.joint < 0 else (self.joint,)


class Named(NamedTuple):
    """One finding.

    Attributes:
        effect: Name in the vocabulary.
        joints: From 0.
        probability: Stated.
        value: Of its first parameter.
        std: Of that.
        unit: Of both.
        instead: What is not excluded.
    """

    effect: str
    joints: tuple[int, ...]
    probability: float
    value: float
    std: float
    unit: str
    instead: tuple[tuple[str, tuple[int, ...]], ...]


class Answer(NamedTuple):
    """What was said.

    Attributes:
        question: To which.
        findings: In order.
        unexplained: Joints of which it is said that something is left, from 0.
        before: Held-out residual over noise, without the findings, shape (n,).
        after: With them, shape (n,).
        truth: Value that the belief had of what was taken out; the mass of a payload [kg].
        seconds: That it took.
    """

    question: Question
    findings: tuple[Named, ...]
    unexplained: tuple[int, ...]
    before: np.ndarray
    after: np.ndarray
    truth: float
    seconds: float

    @property
    def right(self) -> Named | None:
        """The finding that names what was taken out."""
        same = [one for one in self.findings if (one.effect, one.joints) == self.question.place]
        return same[0] if same else None

    @property
    def near(self) -> Named | None:
        """A finding that is right as well, the one named first."""
        alike = AKIN.get(self.question.effect, ())
        place = (self.question.joint % len(self.before),)  # a payload is on the last link
        found = [one for one in self.findings if one.effect in alike and one.joints == place]
        return found[0] if found else None

    @property
    def value(self) -> float:
        """How much of what was taken out was found; NaN for none of it."""
        effects, joints = PARTS.get(self.question.effect, (self.question.effect,)), self.question.place[1]
        parts = [one.value for one in self.findings if one.effect in effects and one.joints == joints]
        return sum(parts) if parts else float("nan")

    @property
    def said(self) -> str:
        """How it was named."""
        if self.right:
            return "named"
        return f"as {self.near.effect}" if self.near else "missed"

    def others(self) -> list[Named]:
        """Findings that are neither."""
        return [one for one in self.findings if one not in (self.right, self.near)]


@cache
def belief(arm: str, known: tuple[str, float] | None, as_drawn: bool = False) -> Model:
    """The belief of an arm, made once a process."""
    return believe(ARMS[arm], known, as_drawn)


def ask(question: Question) -> Answer:
    """Take something out of a belief and diagnose."""
    arm, model = ARMS[question.arm], belief(question.arm, question.known, question.drawn)
    hidden = question.effect if question.joint >= 0 else ""  # what nobody told of needs no taking out
    model = without(model, hidden, question.joint)
    runs = [("identify", run) for run in arm.runs(question.asked.fitted, model)]
    runs += [(HELD_OUT, run) for run in arm.runs(question.asked.held_out, model)]
    found = diagnose(model, runs, question.arm)
    truth = model.stated[f"{NAMES[hidden]}{question.joint + 1}"].value if hidden else question.mass
    return answered(question, found, truth)


def answered(question: Question, found: Diagnosis, truth: float) -> Answer:
    """The part of a diagnosis that is scored."""
    assert found.improvement is not None
    noise = found.improvement.noise
    named = []
    for one in found.findings:
        value, std, unit = next(iter(one.parameters.values()))
        instead = tuple((other.effect, other.joints) for other in one.alternatives)
        named.append(Named(one.effect, one.joints, one.probability, value, std, unit, instead))
    return Answer(
        question,
        tuple(named),
        tuple(one.joint for one in found.remainders),
        found.improvement.before / noise,
        found.improvement.after / noise,
        truth,
        found.seconds,
    )
