"""The choice after a round of a study: conclusions, open questions, and the available runs."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path, PurePosixPath
from typing import Annotated, Any

import numpy as np
from msgspec import Meta, Struct, to_builtins

from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.belief.belief import Belief
from exidyn.identification.diagnosis.belief.gain_item import gain_words
from exidyn.identification.diagnosis.belief.open_items import (
    Subject,
    hidden,
    open_torque,
    remaining,
    unseen_words,
)
from exidyn.identification.diagnosis.questions.shape import Shaped
from exidyn.identification.diagnosis.results.remainder import rms
from exidyn.identification.diagnosis.words.naming import joint_words, lower
from exidyn.identification.diagnosis.words.sentences import dependence
from exidyn.identification.diagnosis.words.verdict import left_on, verdict
from exidyn.identification.errors import NotAFile
from exidyn.identification.model import Model
from exidyn.identification.schema import (
    EffectName,
    JointNumber,
    Name,
    Number,
    Size,
    SizeOrNull,
    check,
    check_joints,
)
from exidyn.trajectories.next_run.choice import DECIDED, OUT_OF_TIME, RUN, UNDECIDABLE, Choice

from .other_gains import OtherGain, gain_sentences

FORMAT = 2
"""Version of the format of choice.json."""
BIT = 1.4426950408889634
"""Bits per nat: files and pages state information in bits."""
ENDED = {
    DECIDED: "Decided: all questions are settled.",
    UNDECIDABLE: "Undecidable by any available run; the open questions, why, and what would settle them:",
    OUT_OF_TIME: "Out of time: the most informative run takes longer than the time that remains.",
}
"""Explanation of each verdict that ends a study."""
VERDICTS = (RUN, *ENDED)
Sentence = Annotated[str, Meta(max_length=10_000)]
Duration = Annotated[float, Meta(gt=0.0, le=1e9)]
"""Duration of a run [s], at most thirty years."""
Finding = tuple[EffectName, list[JointNumber]]
"""Effect and numbers of its joints, from 1."""
Shape = tuple[EffectName, list[JointNumber], str, dict[str, Number]]
"""Effect, numbers of its joints, from 1, kind, and shape parameters by name."""


class ItemRow(Struct, frozen=True):
    """A question: its words, entropy [bit], whether it is open, and whether an available run settles it."""

    words: Sentence
    entropy: Size
    open: bool
    decidable: bool


class OfferRow(Struct, frozen=True):
    """An available run: its durations [s], what a person has to do, and the expected information [bit]."""

    name: Name
    motion: Annotated[float, Meta(ge=0.0, le=1e9)]
    seconds: Duration
    request: Sentence
    gained: Number


class Chosen(Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The chosen run: the file of its motion and what it needs, or the name of an existing recording."""

    plan: Name | None = None
    loaded: bool | None = None
    request: Sentence | None = None
    recording: Name | None = None

    def __post_init__(self) -> None:
        check((self.plan is None) != (self.recording is None), "plan", self.plan, "a plan or a recording")
        path = PurePosixPath(self.plan or "")
        inside = not path.is_absolute() and ".." not in path.parts
        check(inside, "plan", self.plan, "a path below the folder of the study")


class RoundChoice(Struct, frozen=True, kw_only=True):
    """The content of choice.json; information is in [bit].

    Attributes:
        exidyn_study: Version of the format.
        verdict: One of `VERDICTS`.
        believed: Sentences on the conclusions.
        findings: Findings whose questions are settled.
        believed_findings: All findings of the diagnosis.
        possible: Effects that answer an open question.
        left_over_noise: RMS residual of each joint with findings, over the noise floor, by joint [-].
        entropy: Entropy of all open questions.
        hidden: Probability of effects that no run so far could show.
        open_torque: Share of the resolution that parameter values leave open [-].
        items: Questions.
        offers: Available runs, the best first.
        remains: Sentences on what no available run settles.
        moved: Total duration of all motions so far [s].
        asked: Options of the study.
        shapes: Shapes of findings.
        chosen: The next run; None if the study has ended.
    """

    exidyn_study: int = FORMAT
    verdict: str
    believed: list[Sentence]
    findings: list[Finding]
    believed_findings: list[Finding] = []
    possible: list[Finding] = []
    left_over_noise: dict[str, SizeOrNull]
    entropy: Size
    hidden: SizeOrNull = None
    open_torque: SizeOrNull = None
    items: list[ItemRow]
    offers: list[OfferRow]
    remains: list[Sentence]
    moved: Size
    asked: dict[str, Any]
    shapes: list[Shape] = []
    chosen: Chosen | None

    def __post_init__(self) -> None:
        check(self.verdict in VERDICTS, "verdict", self.verdict, f"one of {', '.join(VERDICTS)}")
        continues = self.verdict == RUN
        check(bool(self.offers) or not continues, "offers", self.offers, f"a run, as the verdict is {RUN}")
        check(
            (self.chosen is not None) == continues, "chosen", self.chosen, f"a run where the verdict is {RUN}"
        )
        for place, (_, joints, *_) in enumerate(self.shapes):
            check_joints(joints, f"shapes[{place}][1]", len(self.left_over_noise))

    @classmethod
    def of(
        cls,
        belief: Belief,
        choice: Choice,
        diagnosis: Diagnosis,
        gains: list[OtherGain],
        nominal: Model,
        **known: Any,
    ) -> "RoundChoice":
        """The choice with the conclusions that it is based on, other drive gains among them.

        The further arguments are the fields `moved`, `asked`, `shapes` and `chosen`.
        """
        offers = [(forecast.offer, BIT * forecast.gained) for forecast in choice.forecasts]
        items = zip(choice.items, choice.decidable, strict=True)
        gain_findings = [("drive_gain", [gain.joint + 1]) for gain in gains]
        return cls(
            verdict=choice.verdict,
            believed=[*gain_sentences(gains, nominal), *verdict(diagnosis)],
            findings=sorted([*settled_findings(belief, choice, diagnosis), *gain_findings]),
            believed_findings=believed_findings(diagnosis),
            possible=possible_effects(belief),
            left_over_noise=residual_over_noise(belief, diagnosis),
            entropy=BIT * choice.entropy,
            hidden=hidden(belief),
            open_torque=open_torque(belief),
            items=[ItemRow(item.words, BIT * item.entropy, item.open, settles) for item, settles in items],
            offers=[OfferRow(run.name, run.motion, run.seconds, run.request, gain) for run, gain in offers],
            remains=[*_remains(belief, choice), *_unexplained(diagnosis)],
            **known,
        )

    @property
    def table(self) -> dict[str, Any]:
        """The content of the file as a table."""
        table: dict[str, Any] = to_builtins(self, enc_hook=np.generic.item)
        return table


def believed_findings(diagnosis: Diagnosis) -> list[Finding]:
    """Effect and joints, from 1, of each finding of a diagnosis, sorted by name."""
    return sorted((finding.effect, _numbers(finding.joints)) for finding in diagnosis.findings)


def settled_findings(belief: Belief, choice: Choice, diagnosis: Diagnosis) -> list[Finding]:
    """Effect and joints, from 1, of each finding whose question is settled."""
    answers = [question.answers[0] for question in belief.questions if question.seen]
    pairs = zip(answers, choice.items, strict=False)
    still_open = [(answer.effect, _numbers(answer.joints)) for answer, item in pairs if item.open]
    return [finding for finding in believed_findings(diagnosis) if finding not in still_open]


def possible_effects(belief: Belief) -> list[Finding]:
    """Effect and joints, from 1, of each answer to an open question."""
    questions = [question for question in belief.questions if question.seen and not question.settled]
    answers = [answer for question in questions for answer in question.answers if answer.effect]
    return sorted((answer.effect, _numbers(answer.joints)) for answer in answers)


def _numbers(joints: Sequence[int]) -> list[int]:
    """Numbers of joints from 1, by their indices from 0."""
    return [joint + 1 for joint in joints]


def residual_over_noise(belief: Belief, diagnosis: Diagnosis) -> dict[str, float | None]:
    """RMS residual of all runs with findings, over the noise floor of each joint [-]."""
    assert diagnosis.evidence is not None
    prediction = belief.search.prediction
    ratio = rms(prediction.residual, prediction.rows.weight) / diagnosis.evidence.noise
    return dict(zip(diagnosis.joints, map(float, ratio), strict=True))


def shape_rows(shapes: Sequence[Shaped]) -> list[Shape]:
    """Shapes of findings, joints from 1; only the last shape of each hypothesis is listed."""
    last = {shaped[:3]: shaped.shape for shaped in shapes}
    return [(effect, _numbers(joints), kind, dict(shape)) for (effect, joints, kind), shape in last.items()]


def shapes_in(choice: RoundChoice | None) -> list[Shaped]:
    """Shapes listed in a choice; empty without a choice."""
    return [
        Shaped(effect, tuple(joint - 1 for joint in joints), kind, shape)
        for effect, joints, kind, shape in (choice.shapes if choice else [])
    ]


def _remains(belief: Belief, choice: Choice) -> Iterator[str]:
    """Yield sentences on each question that no available run settles: why, and what would settle it."""
    questions = [question for question in belief.questions if question.seen]
    for place, item in enumerate(choice.items):
        if item not in choice.remains:
            continue
        if place < len(questions):
            yield " ".join(remaining(belief, questions[place]))
        elif item.subject == Subject.UNSEEN:
            yield unseen_words(belief)
        elif item.subject == Subject.GAINS:
            yield gain_words(belief)
        else:
            yield f"Parameter values leave {100 * open_torque(belief):.0f} % of the resolution open."


def _unexplained(diagnosis: Diagnosis) -> Iterator[str]:
    for remainder in diagnosis.remainders:
        joint = lower(joint_words(remainder.joint, diagnosis.joints))
        yield (
            f"No effect in exidyn explains a residual of {left_on(remainder, diagnosis)} on {joint}; "
            f"{dependence(remainder.depends_on)}. To explain it, add an effect to exidyn; "
            "see docs/effects.md."
        )


def require_course(folder: Path, choices: Sequence[tuple[str, RoundChoice]]) -> None:
    """Refuse rounds that cannot belong to one study.

    Args:
        folder: Folder of the study.
        choices: Name and choice of each round.

    Raises:
        NotAFile: If a round follows one that ended the study, or two rounds have different joints.
    """
    for (name, choice), (following, later) in pairwise(choices):
        if choice.verdict != RUN:
            raise NotAFile(
                f"{folder}: {name} ended the study, but {following} follows it; remove {following}"
            )
        if list(choice.left_over_noise) != list(later.left_over_noise):
            raise NotAFile(f"{folder}: {name} and {following} have different joints; remove {following}")
