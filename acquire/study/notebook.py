"""The lab notebook: after each run what was believed, asked and why, and learned."""

from collections.abc import Sequence
from typing import Any

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
from exidyn.trajectories.next_run.choice import RUN

from .choice_file import ENDED, ChoiceTable
from .study_plots import left_plot, open_plot


def notebook(
    robot: str,
    choices: Sequence[tuple[str, ChoiceTable]],
    stopped: str = "",
    stops: Sequence[tuple[str, str]] = (),
) -> str:
    """The page.

    Args:
        robot: Name of the robot.
        choices: Name and choice of each round, as `choice_table` gives it.
        stopped: Why the last run was stopped before its end, and whether the arm stands; empty if it was not.
        stops: Round and reason of every run that was stopped before its end.
    """
    moved = choices[-1][1]["moved"] if choices else 0.0
    note = f"{counted(len(choices), 'run')}; {moved / 60:.1f} min of motion"
    before = [None, *(choice for _, choice in choices)]
    rounds = [(name, choice, earlier) for (name, choice), earlier in zip(choices, before, strict=False)]
    sections = [
        Section("stopped", "The last run was stopped", [Paragraph(stopped)] if stopped else ()),
        Section("runs", "The runs", _summary(rounds)),
        Section("stops", "Runs that were stopped before their end", _stops(stops)),
        *(_round(*one) for one in rounds),
    ]
    return html(Document(f"{robot}: study", note, sections))


def _summary(rounds: Sequence[tuple[str, ChoiceTable, ChoiceTable | None]]) -> list[Block]:
    """A row a run: what was expected of it and what it gave; and what the end means."""
    head = ["round", "run", "motion so far [s]", "expected [bit]", "realised [bit]", "left open [bit]"]
    blocks: list[Block] = [Table(head, [_row(*one) for one in rounds], words=(1,))]
    if not rounds:
        return blocks
    pairs = [(choice, before) for _, choice, before in rounds]
    plots = [
        Figure("What is open", "what was expected of each run beside what it left", open_plot(pairs)),
        Figure("What is left beside all findings", "over noise; 1 is noise alone", left_plot(pairs)),
    ]
    blocks.append(Grid(plots))
    last = rounds[-1][1]
    if last["verdict"] == RUN:
        return blocks
    return [*blocks, Paragraph(ENDED[last["verdict"]]), Statements(last["remains"])]


def _stops(stops: Sequence[tuple[str, str]]) -> list[Block]:
    """A row a run; none without any."""
    return [Table(["round", "why it was stopped"], stops, words=(1,))] if stops else []


def _row(name: str, choice: ChoiceTable, before: ChoiceTable | None) -> list[Cell]:
    so_far, left = Number(choice["moved"], 3), Number(choice["entropy"], 3)
    if before is None:
        return [name, "an excitation", so_far, "-", "-", left]
    best, realised = before["offers"][0], before["entropy"] - choice["entropy"]
    return [name, best["name"], so_far, Number(best["gained"], 3), Number(realised, 3), left]


def _round(name: str, choice: ChoiceTable, before: ChoiceTable | None) -> Section:
    asked = ["The first run: nothing was known but the nominal model."]
    if before is not None:
        best = before["offers"][0]
        asked = [_why(best), _learned(best, before["entropy"] - choice["entropy"])]
    items: list[list[Cell]] = [
        ["open" if one["open"] else "settled", one["words"], Number(one["entropy"], 3), _told(one)]
        for one in choice["items"]
    ]
    blocks: list[Block] = [
        Heading("What was asked, and why"),
        *(Paragraph(words) for words in asked),
        Heading("What is believed"),
        Statements(choice["believed"]),
        Heading("What is open"),
        Table(["", "question", "[bit]", "a run on offer settles it"], items, words=(1, 3)),
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
    text = f"Expected information {best['gained']:.2f} bit, realised {realised:.2f} bit."
    if realised < 0.0:
        text += " The run raised a question that was not open before."
    return text


def _offers(offers: Sequence[dict[str, Any]]) -> Table:
    rows: list[list[Cell]] = [
        [
            Number(1e3 * one["gained"] / one["seconds"], 3),
            one["name"],
            Number(one["motion"], 3),
            Number(one["seconds"] - one["motion"], 3),
            Number(one["gained"], 3),
        ]
        for one in offers
    ]
    head = ["a second [mbit/s]", "run", "motion [s]", "a person's part [s]", "of what is open [bit]"]
    return Table(head, rows, words=(1,))
