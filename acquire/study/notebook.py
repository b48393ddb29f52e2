"""The lab notebook: for each run, why it was chosen, what it taught, and the conclusions so far."""

from collections.abc import Sequence

import numpy as np

from exidyn.identification.document.document import (
    Block,
    Cell,
    Document,
    Figure,
    Grid,
    Heading,
    Number,
    Paragraph,
    Section,
    Statements,
    Table,
)
from exidyn.identification.document.html import html
from exidyn.identification.notebook import counted
from exidyn.identification.pages.svg import Panel, Span
from exidyn.trajectories.next_run.choice import RUN

from .choice_file import ENDED, ItemRow, OfferRow, RoundChoice


def notebook(
    robot: str,
    choices: Sequence[tuple[str, RoundChoice]],
    stopped: str = "",
    stops: Sequence[tuple[str, str]] = (),
) -> str:
    """The page of a study.

    Args:
        robot: Name of the robot.
        choices: Name and choice of each round; see `RoundChoice`.
        stopped: Why the last run was stopped before its end, and whether the arm stands; empty if it was not.
        stops: Round and reason of each run that was stopped before its end.
    """
    moved = choices[-1][1].moved if choices else 0.0
    note = f"{counted(len(choices), 'run')}; {moved / 60:.1f} min of motion"
    previous = [None, *(choice for _, choice in choices)]
    rounds = [(name, choice, before) for (name, choice), before in zip(choices, previous, strict=False)]
    sections = [
        Section("stopped", "The last run was stopped", [Paragraph(stopped)] if stopped else ()),
        Section("runs", "The runs", _summary(rounds)),
        Section("stops", "Runs that were stopped before their end", _stops(stops)),
        *(_round_section(*entry) for entry in rounds),
    ]
    return html(Document(f"{robot}: study", note, sections))


def _summary(rounds: Sequence[tuple[str, RoundChoice, RoundChoice | None]]) -> list[Block]:
    """One row per run with its expected and realized information, and the verdict that ended the study."""
    head = ["round", "run", "motion so far [s]", "expected [bit]", "realized [bit]", "still open [bit]"]
    blocks: list[Block] = [Table(head, [_row(*entry) for entry in rounds], words=(1,))]
    if not rounds:
        return blocks
    pairs = [(choice, before) for _, choice, before in rounds]
    plots = [
        Figure("Open questions", "expected and actual entropy after each run", open_plot(pairs)),
        Figure("Residuals with findings", "residual / noise floor; 1 is noise alone", residual_plot(pairs)),
    ]
    blocks.append(Grid(plots))
    last = rounds[-1][1]
    if last.verdict == RUN:
        return blocks
    return [*blocks, Paragraph(ENDED[last.verdict]), Statements(last.remains)]


def _stops(stops: Sequence[tuple[str, str]]) -> list[Block]:
    """One row per stopped run; empty if there is none."""
    return [Table(["round", "why it was stopped"], stops, words=(1,))] if stops else []


def _row(name: str, choice: RoundChoice, before: RoundChoice | None) -> list[Cell]:
    so_far, still_open = Number(choice.moved, 3), Number(choice.entropy, 3)
    if before is None:
        return [name, "an excitation", so_far, "-", "-", still_open]
    best, realized = before.offers[0], before.entropy - choice.entropy
    return [name, best.name, so_far, Number(best.gained, 3), Number(realized, 3), still_open]


def _round_section(name: str, choice: RoundChoice, before: RoundChoice | None) -> Section:
    reasons = ["The first run: only the nominal model was known."]
    if before is not None:
        best = before.offers[0]
        reasons = [_reason(best), _information(best, before.entropy - choice.entropy)]
    items: list[list[Cell]] = [
        ["open" if item.open else "settled", item.words, Number(item.entropy, 3), _decidable(item)]
        for item in choice.items
    ]
    blocks: list[Block] = [
        Heading("Why this run"),
        *(Paragraph(words) for words in reasons),
        Heading("Conclusions so far"),
        Statements(choice.believed),
        Heading("Open questions"),
        Table(["", "question", "[bit]", "an available run settles it"], items, words=(1, 3)),
    ]
    if choice.offers:
        blocks += [Heading("Available runs"), _offer_table(choice.offers)]
    return Section(name, name.replace("-", " ").capitalize(), blocks)


def _decidable(item: ItemRow) -> str:
    if not item.open:
        return ""
    return "yes" if item.decidable else "no"


def _reason(best: OfferRow) -> str:
    request = f" {best.request}." if best.request else ""
    return (
        f"{best.name.capitalize()}: of all available runs it is expected to give the most information "
        f"per second, {best.gained:.2f} bit in {best.seconds:.0f} s.{request}"
    )


def _information(best: OfferRow, realized: float) -> str:
    text = f"Expected information {best.gained:.2f} bit, realized {realized:.2f} bit."
    if realized < 0.0:
        text += " The run raised a new question."
    return text


def _offer_table(offers: Sequence[OfferRow]) -> Table:
    rows: list[list[Cell]] = [
        [
            Number(1e3 * offer.gained / offer.seconds, 3),
            offer.name,
            Number(offer.motion, 3),
            Number(offer.seconds - offer.motion, 3),
            Number(offer.gained, 3),
        ]
        for offer in offers
    ]
    head = ["information rate [mbit/s]", "run", "motion [s]", "manual work [s]", "information [bit]"]
    return Table(head, rows, words=(1,))


Pairs = Sequence[tuple[RoundChoice, RoundChoice | None]]
"""The choice of each round and the choice of the round before it."""
STYLES = ("measured", "predicted", "residual", "predicted dashed", "before thin", "after thin")
"""Line styles of the joints, used in turn."""


def open_plot(pairs: Pairs) -> str:
    """Plot the total entropy after each run, as expected and as realized."""
    moved = np.array([choice.moved for choice, _ in pairs], float)
    entropy = np.array([choice.entropy for choice, _ in pairs], float)
    expected = [np.nan if before is None else before.entropy - before.offers[0].gained for _, before in pairs]
    across = Span.around(np.append(moved, 0.0), margin=0.03)
    height = Span.around(entropy, np.append(np.array(expected, float), 0.0))
    panel = Panel.single(across, height, 560, 180, top=22)
    return panel.plot(
        "open questions over motion",
        ("motion so far [s]", "entropy [bit]"),
        [("predicted", "actual"), ("residual", "expected")],
        panel.line(moved, entropy, "predicted"),
        panel.dots(moved, entropy, "runs"),
        _expected_lines(panel, moved, entropy, np.array(expected, float)),
    )


def _expected_lines(panel: Panel, moved: np.ndarray, entropy: np.ndarray, expected: np.ndarray) -> str:
    """A line per run, from the entropy before it to the entropy expected after it."""
    return "".join(
        panel.line(moved[k - 1 : k + 1], np.array([entropy[k - 1], expected[k]]), "residual")
        for k in range(1, len(moved))
    )


def residual_plot(pairs: Pairs) -> str:
    """Plot the residual of each joint with findings, over its noise floor."""
    ratios = [choice.left_over_noise for choice, _ in pairs]
    moved = np.array([choice.moved for choice, _ in pairs], float)
    joints = list(ratios[0])
    across = Span.around(np.append(moved, 0.0), margin=0.03)
    lines = [np.array([ratio[joint] for ratio in ratios], float) for joint in joints]
    panel = Panel.single(across, Span.around(*lines, np.array([0.0, 1.0])), 560, 180, top=22)
    styles = [STYLES[place % len(STYLES)] for place in range(len(joints))]
    return panel.plot(
        "residual over noise floor of each joint, over motion",
        ("motion so far [s]", "residual / noise floor [-]"),
        list(zip(styles, joints, strict=True)),
        panel.line(np.array(across), np.ones(2), "zero"),
        *(
            panel.line(moved, line, style) + panel.dots(moved, line, "dots")
            for line, style in zip(lines, styles, strict=True)
        ),
    )
