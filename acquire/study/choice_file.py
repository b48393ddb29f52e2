"""A choice as a table: what was believed, what is open, what each run on offer would do about it."""

from collections.abc import Iterator, Sequence
from typing import Any

from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.belief.belief import Belief
from exidyn.identification.diagnosis.belief.gain_item import GAINS, gain_words
from exidyn.identification.diagnosis.belief.open_items import (
    UNSEEN,
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
"""Bits in a nat: people count in bits."""
ENDED = {
    DECIDED: "Decided: everything that was open is settled.",
    UNDECIDABLE: "Undecidable by any run on offer; what remains, why, and what would settle it:",
    OUT_OF_TIME: "Out of time: the run that would settle most takes longer than is left.",
}
"""What the end of a study means."""
ChoiceTable = dict[str, Any]


def choice_table(belief: Belief, choice: Choice, diagnosis: Diagnosis) -> dict[str, Any]:
    """What was believed, what is open, what each run on offer would do about it; information in [bit]."""
    return {
        "exidyn_study": FORMAT,
        "verdict": choice.verdict,
        "believed": verdict(diagnosis),
        "findings": settled_findings(belief, choice, diagnosis),
        "believed_findings": believed_findings(diagnosis),
        "possible": possible_effects(belief),
        "left_over_noise": left_over_noise(belief, diagnosis),
        "entropy": BIT * choice.entropy,
        "hidden": hidden(belief),
        "open_torque": open_torque(belief),
        "items": [
            {"words": one.words, "entropy": BIT * one.entropy, "open": one.open, "decidable": decidable}
            for one, decidable in zip(choice.items, choice.decidable, strict=True)
        ],
        "offers": [
            {
                "name": one.offer.name,
                "motion": one.offer.motion,
                "seconds": one.offer.seconds,
                "request": one.offer.request,
                "gained": BIT * one.gained,
            }
            for one in choice.forecasts
        ],
        "remains": [*_remains(belief, choice), *_unexplained(diagnosis)],
    }


def believed_findings(diagnosis: Diagnosis) -> list[list[Any]]:
    """Effect and joints, from 1, of all findings of a diagnosis, in the order of their names."""
    return sorted([one.effect, [joint + 1 for joint in one.joints]] for one in diagnosis.findings)


def settled_findings(belief: Belief, choice: Choice, diagnosis: Diagnosis) -> list[list[Any]]:
    """The same without those that are open."""
    asked = [question.answers[0] for question in belief.questions if question.seen]
    open_ones = [
        [one.effect, [joint + 1 for joint in one.joints]]
        for one, item in zip(asked, choice.items, strict=False)
        if item.open
    ]
    return [one for one in believed_findings(diagnosis) if one not in open_ones]


def possible_effects(belief: Belief) -> list[list[Any]]:
    """Effect and joints, from 1, of all answers to questions that are open."""
    asked = [question for question in belief.questions if question.seen and not question.settled]
    return sorted(
        [one.effect, [joint + 1 for joint in one.joints]]
        for question in asked
        for one in question.answers
        if one.effect
    )


def left_over_noise(belief: Belief, diagnosis: Diagnosis) -> dict[str, float]:
    """What is left of all runs beside what was found, over the noise of each joint [-]."""
    assert diagnosis.evidence is not None
    prediction = belief.search.prediction
    left = rms(prediction.residual, prediction.rows.weight) / diagnosis.evidence.noise
    return dict(zip(diagnosis.joints, map(float, left), strict=True))


def shape_table(shapes: Sequence[Shaped]) -> list[list[Any]]:
    """Shapes of findings, joints from 1; of one hypothesis the last."""
    last = {one[:3]: one.shape for one in shapes}
    return [
        [effect, [joint + 1 for joint in joints], kind, shape]
        for (effect, joints, kind), shape in last.items()
    ]


def read_shapes(choice: dict[str, Any] | None) -> list[Shaped]:
    """The inverse: what a choice says of shapes; none before the first."""
    return [
        Shaped(effect, tuple(joint - 1 for joint in joints), kind, shape)
        for effect, joints, kind, shape in (choice or {}).get("shapes", [])
    ]


def _remains(belief: Belief, choice: Choice) -> Iterator[str]:
    """What no run on offer decides, why, and what would, in sentences."""
    questions = [question for question in belief.questions if question.seen]
    for place, item in enumerate(choice.items):
        if item not in choice.remains:
            continue
        if place < len(questions):
            yield " ".join(remaining(belief, questions[place]))
        elif item.words == UNSEEN:
            yield unseen_words(belief)
        elif item.words == GAINS:
            yield gain_words(belief)
        else:
            yield f"Values of parameters leave {100 * open_torque(belief):.0f} % of the resolution open."


def _unexplained(diagnosis: Diagnosis) -> Iterator[str]:
    for one in diagnosis.remainders:
        where = lower(joint_words(one.joint, diagnosis.joints))
        yield (
            f"On {where} {left_on(one, diagnosis)} is left that none of the effects that exidyn knows "
            f"explains; {dependence(one.depends_on)}. What would explain it: an effect that is added to "
            "exidyn, see docs/effects.md."
        )
