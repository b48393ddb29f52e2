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
    parts = [
        INTRODUCTION,
        summary(figures, answers),
        known_section(answers),
        sets_section(answers),
        SIMULATED,
    ]
    path.write_text("\n".join([*parts, SIMULATED]), encoding="utf-8")
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
    header = ["set", "known, named", "size off", "false", "unverified", "again, nothing named"]
    return f"{table(['all sets', ''], rows)}\n{table(header, each)}"


def fixed_words(figures: dict[str, Any]) -> str:
    """On how many sets nothing is named again."""
    total, spared = figures["asked_again"], figures["at_fixed_point_but_for_what_no_model_holds"]
    return f"on {figures['at_fixed_point']} of {total} sets; on {spared} but for what no model holds"


def row_of(one: Answer) -> list[str]:
    """A set in numbers."""
    verdicts = [name["verdict"] for name in one["named"]]
    asked = [known["named"] for known in one["known"] if known["expected"]]
    off = sum(known.get("right") is False for known in one["known"])
    again = "not asked" if not one["again"] else "yes" if fixed(one) else "no"
    numbers = [off, verdicts.count("false"), verdicts.count("unverified")]
    return [CASES[one["case"]].title, f"{sum(asked)} of {len(asked)}", *map(str, numbers), again]


def known_section(answers: Sequence[Answer]) -> str:
    """Known effects of each set, with those of one joint in a row."""
    rows: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for one in answers:
        for known in one["known"]:
            if known["expected"]:
                rows.setdefault((CASES[one["case"]].title, title(known)), []).append(known)
    lines = [[*key, known[0]["how"], named_words(known)] for key, known in rows.items()]
    return f"## Known effects\n\n{table(['set', 'effect', 'known by', 'named'], lines)}"


def named_words(known: Sequence[dict[str, Any]]) -> str:
    """How many of the effects are named, and of how many the size is off."""
    named, off = (sum(map(bool, part)) for part in zip(*map(_named_and_off, known), strict=True))
    words = "yes" if len(known) == 1 else f"{named} of {len(known)}"
    return (words if named else "**missed**") + (", **size off**" if off else "")


def _named_and_off(known: dict[str, Any]) -> tuple[bool, bool]:
    return known["named"], known["named"] and known["right"] is False


def sets_section(answers: Sequence[Answer]) -> str:
    """Machine and recordings of each set."""
    titles = [CASES[one["case"]].title for one in answers]
    rows = [[name, SETS[name]] for name in titles if name in SETS]
    return f"## Recordings\n\n{table(['set', 'machine and recordings'], rows)}"
