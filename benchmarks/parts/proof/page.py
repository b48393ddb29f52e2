"""docs/proof.md: what was named on the real recordings beside what is known of them, in tables."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..diagnose_real.score import fixed
from ..diagnose_real.sets import CASES
from .open_loop import worse_position
from .texts import INTRODUCTION, SETS, SIMULATED

Answer = dict[str, Any]


def title(named: dict[str, Any]) -> str:
    """Effect and joints."""
    joints = "" if named["joints"] == "-" else f" {named['joints']}"
    return named["effect"].replace("_", " ") + joints


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def write_pages(path: Path, figures: dict[str, Any], answers: Sequence[Answer]) -> None:
    """Write the page."""
    parts = [INTRODUCTION, summary(figures, answers), recordings(answers), SIMULATED]
    path.write_text("\n".join(parts), encoding="utf-8")
    print(f"\npage in {path}")


def summary(figures: dict[str, Any], answers: Sequence[Answer]) -> str:
    """The figures of all rows, and what of each set is behind them."""
    rows = [
        ["known effects named", f"{figures['known_named']} of {figures['known']}"],
        ["of all that are named, size off", str(figures["sizes_off"])],
        ["false names", f"{figures['false_names']} of {figures['names']}"],
        ["unverified names", f"{figures['unverified']} of {figures['names']}"],
        ["not named, though another name for it has 90 % or more", str(figures["named_otherwise"])],
        ["diagnosed again, nothing named", fixed_words(figures)],
        ["joints worse held out than before, by more than 2 %", str(figures["worse_held_out"])],
        *[["EMPS, position", worse_position(one["open_loop"])] for one in answers if one["open_loop"]],
    ]
    each = [row_of(one) for one in answers]
    header = ["set", "known, named", "known, missed", "false", "unverified", "again, nothing named"]
    return f"{table(['all sets', ''], rows)}\n{table(header, each)}"


def fixed_words(figures: dict[str, Any]) -> str:
    """On how many sets nothing is named again."""
    total, spared = figures["asked_again"], figures["at_fixed_point_but_for_what_no_model_holds"]
    return f"on {figures['at_fixed_point']} of {total} sets; on {spared} but for what no model holds"


def row_of(one: Answer) -> list[str]:
    """A set: names of known effects, and numbers."""
    verdicts = [name["verdict"] for name in one["named"]]
    again = "not asked" if not one["again"] else "yes" if fixed(one) else "no"
    numbers = map(str, (verdicts.count("false"), verdicts.count("unverified")))
    return [CASES[one["case"]].title, *known_words(one["known"]), *numbers, again]


def known_words(known: Sequence[dict[str, Any]]) -> list[str]:
    """Known effects that are named, and those that are missed."""
    words: tuple[list[str], list[str]] = ([], [])
    for effect in known:
        if effect["expected"]:
            off = ", **size off**" if effect["named"] and effect["right"] is False else ""
            words[not effect["named"]].append(title(effect) + off)
    return ["; ".join(part) for part in words]


def recordings(answers: Sequence[Answer]) -> str:
    """Machine and recordings of each set."""
    titles = [CASES[one["case"]].title for one in answers]
    lines = [f"* **{name}**: {SETS[name]}\n" for name in titles if name in SETS]
    return f"## Recordings\n\n{''.join(lines)}"
