"""A choice as a table of numbers and words, for its file and the notebook."""

from collections.abc import Iterator, Sequence
from typing import Any

from exidyn.identify.diagnosis import Diagnosis
from exidyn.identify.diagnosis.belief.belief import Belief
from exidyn.identify.diagnosis.belief.open_items import UNSEEN, hidden, open_torque, remaining, unseen_words
from exidyn.identify.diagnosis.questions.shape import Shaped
from exidyn.identify.diagnosis.words.naming import joint_words, lower
from exidyn.identify.diagnosis.words.verdict import left_on, verdict
from exidyn.trajectories.next_run.choice import Choice

from .rounds import FORMAT

BIT = 1.4426950408889634
"""Bits in a nat: people count in bits."""


def choice_table(belief: Belief, choice: Choice, diagnosis: Diagnosis) -> dict[str, Any]:
    """What was believed, what is open, what each run on offer would do about it; information in [bit]."""
    return {
        "exidyn_study": FORMAT,
        "verdict": choice.verdict,
        "believed": verdict(diagnosis),
        "findings": settled_findings(belief, choice, diagnosis),
        "believed_findings": believed_findings(diagnosis),
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
                "expected": BIT * float(choice.entropy - one.left.sum()),
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
        else:
            yield f"Values of parameters leave {100 * open_torque(belief):.0f} % of the resolution open."


def _unexplained(diagnosis: Diagnosis) -> Iterator[str]:
    for one in diagnosis.remainders:
        where = lower(joint_words(one.joint, diagnosis.joints))
        yield (
            f"On {where} {left_on(one, diagnosis)} is left that none of the effects that exidyn knows "
            f"explains; it depends on {one.depends_on}. What would explain it: an effect that is added to "
            "exidyn, see docs/effects.md."
        )
