"""The lab notebook: after each run what was believed, what was asked and why, and what was learned."""

from collections.abc import Sequence
from typing import Any

from markupsafe import Markup

from exidyn.identify.pages.report_html import NAMELESS, heading, listing, number, paragraph, section, table
from exidyn.identify.pages.report_page import page
from exidyn.trajectories.next_run.choice import DECIDED, OUT_OF_TIME, RUN, UNDECIDABLE

ENDED = {
    DECIDED: "Decided: everything that was open is settled.",
    UNDECIDABLE: "Undecidable by any run on offer; what remains, why, and what would settle it:",
    OUT_OF_TIME: "Out of time: the run that would settle most takes longer than is left.",
}
"""What the end of a study means."""


def notebook(robot: str, choices: Sequence[tuple[str, dict[str, Any]]], stopped: str = "") -> str:
    """The page.

    Args:
        robot: Its name.
        choices: Name and choice of each round, as `choice_table` gives it.
        stopped: Why the last run was stopped before its end, and whether the arm stands; empty if it was not.
    """
    moved = choices[-1][1]["moved"] if choices else 0.0
    runs = "run" if len(choices) == 1 else "runs"
    note = f"{len(choices)} {runs}; {moved / 60:.1f} min of motion"
    body = [section("stopped", "The last run was stopped", paragraph(stopped))] if stopped else []
    body.append(_summary(choices))
    for place, (name, choice) in enumerate(choices):
        body.append(_round(name, choice, choices[place - 1][1] if place else None))
    return page(f"{robot}: study", f"{robot}: study", note, "".join(body))


def _summary(choices: Sequence[tuple[str, dict[str, Any]]]) -> Markup:
    """A row a run: what was expected of it and what it gave."""
    rows = [
        _row(name, choice, choices[place - 1][1] if place else None)
        for place, (name, choice) in enumerate(choices)
    ]
    head = ["round", "run", "motion so far [s]", "expected [bit]", "realised [bit]", "left open [bit]"]
    return section(
        "runs", "The runs", table(head, rows, words=(0, 1)), *_end(choices[-1][1] if choices else None)
    )


def _row(name: str, choice: dict[str, Any], before: dict[str, Any] | None) -> list[str]:
    so_far, left = number(choice["moved"], 3), number(choice["entropy"], 3)
    if before is None:
        return [name, "an excitation", so_far, NAMELESS, NAMELESS, left]
    best, realised = before["offers"][0], before["entropy"] - choice["entropy"]
    return [name, best["name"], so_far, number(best["expected"], 3), number(realised, 3), left]


def _end(choice: dict[str, Any] | None) -> list[Markup]:
    if choice is None or choice["verdict"] == RUN:
        return []
    remains = choice["remains"]
    return [paragraph(ENDED[choice["verdict"]]), *([listing(remains)] if remains else [])]


def _round(name: str, choice: dict[str, Any], before: dict[str, Any] | None) -> Markup:
    asked = [paragraph("The first run: nothing was known but the nominal model.")]
    if before is not None:
        best = before["offers"][0]
        asked = [paragraph(_why(best))]
        asked.append(paragraph(_learned(best, before["entropy"] - choice["entropy"])))
    items = [
        [one["words"], number(one["entropy"], 3), "open" if one["open"] else "settled", _told(one)]
        for one in choice["items"]
    ]
    parts = [
        heading("What was asked, and why"),
        *asked,
        heading("What is believed"),
        listing(choice["believed"]),
    ]
    parts += [
        heading("What is open"),
        table(["question", "[bit]", "", "a run on offer settles it"], items, words=(0, 2, 3)),
    ]
    if choice["offers"]:
        parts += [heading("Runs on offer"), _offers(choice["offers"])]
    return section(name, name.replace("-", " ").capitalize(), *parts)


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


def _offers(offers: Sequence[dict[str, Any]]) -> Markup:
    rows = [
        [
            one["name"],
            one["request"],
            number(one["seconds"], 3),
            number(one["gained"], 3),
            number(1e3 * one["gained"] / one["seconds"], 3),
        ]
        for one in offers
    ]
    head = ["run", "asks of a person", "takes [s]", "of what is open [bit]", "a second [mbit/s]"]
    return table(head, rows, words=(0, 1))
