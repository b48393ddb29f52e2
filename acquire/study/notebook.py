"""A choice as a table, and the lab notebook: after each run what was believed, asked and why, and learned."""

from collections.abc import Iterator, Sequence
from typing import Any

from exidyn.identify.diagnosis import Diagnosis
from exidyn.identify.diagnosis.belief.belief import Belief
from exidyn.identify.diagnosis.belief.gain_item import GAINS, gain_words
from exidyn.identify.diagnosis.belief.open_items import UNSEEN, hidden, open_torque, remaining, unseen_words
from exidyn.identify.diagnosis.questions.shape import Shaped
from exidyn.identify.diagnosis.words.naming import joint_words, lower
from exidyn.identify.diagnosis.words.sentences import dependence
from exidyn.identify.diagnosis.words.verdict import left_on, verdict
from exidyn.identify.document.document import (
    Block,
    Cell,
    Document,
    Heading,
    Number,
    Paragraph,
    Section,
    Statements,
    Table,
)
from exidyn.identify.document.html import html
from exidyn.identify.notebook import counted
from exidyn.trajectories.next_run.choice import DECIDED, OUT_OF_TIME, RUN, UNDECIDABLE, Choice

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


def notebook(robot: str, choices: Sequence[tuple[str, ChoiceTable]], stopped: str = "") -> str:
    """The page.

    Args:
        robot: Name of the robot.
        choices: Name and choice of each round, as `choice_table` gives it.
        stopped: Why the last run was stopped before its end, and whether the arm stands; empty if it was not.
    """
    moved = choices[-1][1]["moved"] if choices else 0.0
    note = f"{counted(len(choices), 'run')}; {moved / 60:.1f} min of motion"
    before = [None, *(choice for _, choice in choices)]
    rounds = [(name, choice, earlier) for (name, choice), earlier in zip(choices, before, strict=False)]
    sections = [
        Section("stopped", "The last run was stopped", [Paragraph(stopped)] if stopped else ()),
        Section("runs", "The runs", _summary(rounds)),
        *(_round(*one) for one in rounds),
    ]
    return html(Document(f"{robot}: study", note, sections))


def _summary(rounds: Sequence[tuple[str, ChoiceTable, ChoiceTable | None]]) -> list[Block]:
    """A row a run: what was expected of it and what it gave; and what the end means."""
    head = ["round", "run", "motion so far [s]", "expected [bit]", "realised [bit]", "left open [bit]"]
    blocks: list[Block] = [Table(head, [_row(*one) for one in rounds], words=(1,))]
    last = rounds[-1][1] if rounds else None
    if last is None or last["verdict"] == RUN:
        return blocks
    return [*blocks, Paragraph(ENDED[last["verdict"]]), Statements(last["remains"])]


def _row(name: str, choice: ChoiceTable, before: ChoiceTable | None) -> list[Cell]:
    so_far, left = Number(choice["moved"], 3), Number(choice["entropy"], 3)
    if before is None:
        return [name, "an excitation", so_far, "-", "-", left]
    best, realised = before["offers"][0], before["entropy"] - choice["entropy"]
    return [name, best["name"], so_far, Number(best["expected"], 3), Number(realised, 3), left]


def _round(name: str, choice: ChoiceTable, before: ChoiceTable | None) -> Section:
    asked = ["The first run: nothing was known but the nominal model."]
    if before is not None:
        best = before["offers"][0]
        asked = [_why(best), _learned(best, before["entropy"] - choice["entropy"])]
    items: list[list[Cell]] = [
        [one["words"], Number(one["entropy"], 3), "open" if one["open"] else "settled", _told(one)]
        for one in choice["items"]
    ]
    blocks: list[Block] = [
        Heading("What was asked, and why"),
        *(Paragraph(words) for words in asked),
        Heading("What is believed"),
        Statements(choice["believed"]),
        Heading("What is open"),
        Table(["question", "[bit]", "", "a run on offer settles it"], items, words=(2, 3)),
    ]
    if choice["offers"]:
        blocks += [Heading("Runs on offer"), _offers(choice["offers"])]
    return Section(name, name.replace("-", " ").capitalize(), blocks)


def _told(item: dict[str, Any]) -> str:
    if not item["open"]:
        return ""
    return "yes" if item["decidable"] else "no"


def _why(best: dict[str, Any]) -> str:
    request = f" {best['request']}." if best["request"] else ""
    return (
        f"{best['name'].capitalize()}: of all runs on offer it takes most off what is open in a second, "
        f"{best['gained']:.2f} bit in {best['seconds']:.0f} s.{request}"
    )


def _learned(best: dict[str, Any], realised: float) -> str:
    text = f"Expected information {best['expected']:.2f} bit, realised {realised:.2f} bit."
    if realised < 0.0:
        text += " The run raised a question that was not open before."
    return text


def _offers(offers: Sequence[dict[str, Any]]) -> Table:
    rows: list[list[Cell]] = [
        [
            one["name"],
            one["request"],
            Number(one["seconds"], 3),
            Number(one["gained"], 3),
            Number(1e3 * one["gained"] / one["seconds"], 3),
        ]
        for one in offers
    ]
    head = ["run", "asks of a person", "takes [s]", "of what is open [bit]", "a second [mbit/s]"]
    return Table(head, rows, words=(1,))
