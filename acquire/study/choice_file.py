"""A choice as a table: conclusions, open questions, and the information expected of each available run."""

from collections.abc import Iterator, Sequence
from typing import Any

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
from exidyn.trajectories.next_run.choice import DECIDED, OUT_OF_TIME, UNDECIDABLE, Choice

from .rounds import FORMAT

BIT = 1.4426950408889634
"""Bits per nat: files and pages state information in bits."""
ENDED = {
    DECIDED: "Decided: all questions are settled.",
    UNDECIDABLE: "Undecidable by any available run; the open questions, why, and what would settle them:",
    OUT_OF_TIME: "Out of time: the most informative run takes longer than the time that remains.",
}
"""Explanation of each verdict that ends a study."""
ChoiceTable = dict[str, Any]


def choice_table(belief: Belief, choice: Choice, diagnosis: Diagnosis) -> dict[str, Any]:
    """Conclusions, open questions, and available runs as a table; information in [bit]."""
    return {
        "exidyn_study": FORMAT,
        "verdict": choice.verdict,
        "believed": verdict(diagnosis),
        "findings": settled_findings(belief, choice, diagnosis),
        "believed_findings": believed_findings(diagnosis),
        "possible": possible_effects(belief),
        "left_over_noise": residual_over_noise(belief, diagnosis),
        "entropy": BIT * choice.entropy,
        "hidden": hidden(belief),
        "open_torque": open_torque(belief),
        "items": [
            {"words": item.words, "entropy": BIT * item.entropy, "open": item.open, "decidable": decidable}
            for item, decidable in zip(choice.items, choice.decidable, strict=True)
        ],
        "offers": [
            {
                "name": forecast.offer.name,
                "motion": forecast.offer.motion,
                "seconds": forecast.offer.seconds,
                "request": forecast.offer.request,
                "gained": BIT * forecast.gained,
            }
            for forecast in choice.forecasts
        ],
        "remains": [*_remains(belief, choice), *_unexplained(diagnosis)],
    }


def believed_findings(diagnosis: Diagnosis) -> list[list[Any]]:
    """Effect and joints, from 1, of each finding of a diagnosis, sorted by name."""
    return sorted([finding.effect, [joint + 1 for joint in finding.joints]] for finding in diagnosis.findings)


def settled_findings(belief: Belief, choice: Choice, diagnosis: Diagnosis) -> list[list[Any]]:
    """Effect and joints, from 1, of each finding whose question is settled."""
    answers = [question.answers[0] for question in belief.questions if question.seen]
    still_open = [
        [answer.effect, [joint + 1 for joint in answer.joints]]
        for answer, item in zip(answers, choice.items, strict=False)
        if item.open
    ]
    return [finding for finding in believed_findings(diagnosis) if finding not in still_open]


def possible_effects(belief: Belief) -> list[list[Any]]:
    """Effect and joints, from 1, of each answer to an open question."""
    questions = [question for question in belief.questions if question.seen and not question.settled]
    return sorted(
        [answer.effect, [joint + 1 for joint in answer.joints]]
        for question in questions
        for answer in question.answers
        if answer.effect
    )


def residual_over_noise(belief: Belief, diagnosis: Diagnosis) -> dict[str, float]:
    """RMS residual of all runs with findings, over the noise floor of each joint [-]."""
    assert diagnosis.evidence is not None
    prediction = belief.search.prediction
    ratio = rms(prediction.residual, prediction.rows.weight) / diagnosis.evidence.noise
    return dict(zip(diagnosis.joints, map(float, ratio), strict=True))


def shape_table(shapes: Sequence[Shaped]) -> list[list[Any]]:
    """Shapes of findings, joints from 1; only the last shape of each hypothesis is listed."""
    last = {shaped[:3]: shaped.shape for shaped in shapes}
    return [
        [effect, [joint + 1 for joint in joints], kind, shape]
        for (effect, joints, kind), shape in last.items()
    ]


def read_shapes(choice: dict[str, Any] | None) -> list[Shaped]:
    """Shapes listed in the table of a choice; empty without a choice."""
    return [
        Shaped(effect, tuple(joint - 1 for joint in joints), kind, shape)
        for effect, joints, kind, shape in (choice or {}).get("shapes", [])
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
