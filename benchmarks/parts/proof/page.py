"""docs/proof.md: what was named on the real recordings beside what is known of them, in tables."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from exidyn.identification.diagnosis.search.selected import NAMED

from ..diagnose_real.score import fixed
from ..diagnose_real.sets import CASES
from .open_loop import worse_position
from .texts import ABOUT, INTRODUCTION, OPEN_LOOP, SIMULATED

Answer = dict[str, Any]


def title(named: dict[str, Any]) -> str:
    """Effect and joints."""
    joints = "" if named["joints"] == "-" else f" {named['joints']}"
    return named["effect"].replace("_", " ") + joints


def verdict(known: dict[str, Any]) -> str:
    """Named with its probability, or missed."""
    if not known["named"]:
        return "**missed**"
    size = ", **size off**" if known["right"] is False else ""
    return f"named, {percent(known['probability'])}{size}"


def percent(probability: float) -> str:
    """A probability, never rounded to certainty."""
    return "above 99.9 %" if probability > 0.999 else f"{100 * probability:.3g} %"


def gains(one: Answer) -> list[str]:
    """Residual before and after, joint by joint."""
    found = one["improvement"]
    return (
        [f"{a:.3g} → {b:.3g}" for a, b in zip(found["before"], found["after"], strict=True)] if found else []
    )


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def write_pages(path: Path, figures: dict[str, Any], answers: Sequence[Answer]) -> None:
    """Write the page."""
    given = {one["case"]: one for one in answers}
    parts = [INTRODUCTION, summary(figures, answers)]
    parts += [section(given[key]) for key in ABOUT if key in given]
    parts += [known_section(answers), SIMULATED]
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
    """Each known effect in a line."""
    lines = [
        [CASES[one["case"]].title, title(known), evidence(known), known["size"], verdict(known)]
        for one in answers
        for known in one["known"]
        if known["expected"] or known["named"]
    ]
    return f"## All known effects\n\n{table(['set', 'effect', 'known by', 'known size', ''], lines)}"


def evidence(known: dict[str, Any]) -> str:
    """How an effect is known, with the figures of the fit that shows it."""
    return "; ".join(part for part in (known["how"], known["shown"]) if part)


def section(one: Answer) -> str:
    """One set: what is known, what was given, named, left and missed."""
    about, case = ABOUT[one["case"]], CASES[one["case"]]
    known = [
        [title(k), evidence(k), k["size"], verdict(k), k.get("found", k.get("near", ""))]
        for k in one["known"]
        if k["expected"] or k["named"]
    ]
    parts = [f"## {about.heading}\n", f"{about.what} Given: {case.prior}.\n"]
    if known:
        parts.append(table(["known effect", "known by", "known size", "", "found, or how near"], known))
    parts += [named_words(one), budget_words(one, about.unit)]
    if one["open_loop"]:
        rows = [
            [model, *(f"{error:.2f}" for error in kinds.values())]
            for model, kinds in one["open_loop"].items()
        ]
        parts += [f"{OPEN_LOOP}\n", table(["model", "fitted run", "held out"], rows)]
        parts.append(f"Position held out, {worse_position(one['open_loop'])}.\n")
    return "\n".join([*parts, again_words(one), missed_words(one)])


def named_words(one: Answer) -> str:
    """Names beside the known ones, and what is undecided."""
    other = [name for name in (*one["named"], *one["undecided"]) if name["verdict"] != "known"]
    if not other:
        return "Nothing else is named.\n" if one["named"] else "Nothing is named.\n"
    sure = "" if one["named"] else "Nothing is named. "
    for name in one["undecided"]:
        if name["instead"] >= NAMED:
            effect, _, rest = name["why"].split(",")[0].partition(" ")
            more = f"{effect.replace('_', ' ')} {rest}"
            sure += f"{title(name)} is in the fit without a name, and its other name has more: {more}. "
    rows = [[title(o), o["verdict"], percent(o["probability"]), o["size"], o["why"]] for o in other]
    return f"{sure}Besides:\n\n{table(['effect', '', 'probability', 'size', 'why, or what else'], rows)}"


def budget_words(one: Answer, unit: str) -> str:
    """Residual of runs held out per joint."""
    if not one["improvement"]:
        return ""
    return table(
        ["residual held out", *(f"J{j + 1}" for j in range(one["joints"]))],
        [[f"without and with findings [{unit}]", *gains(one)]],
    )


def again_words(one: Answer) -> str:
    """What a second diagnosis names with the first one's model."""
    again = one["again"]
    if not again:
        return ""
    if not again["held"] and not again["lost"]:
        return "Not diagnosed again, as nothing is in the fit.\n"
    lost = ", ".join(effect.replace("_", " ") for effect in again["lost"])
    text = f"Diagnosed again with what was found ({again['held']} in the model"
    text += f"; no model holds {lost})" if lost else ")"
    return f"{text}: {'; '.join(again['named']) or 'nothing'} named.\n"


def missed_words(one: Answer) -> str:
    """What is still missed, plainly."""
    missed = [
        f"{title(k)} ({k['how']}) is not named" for k in one["known"] if k["expected"] and not k["named"]
    ]
    missed += [f"left on {text}" for text in one["left"]]
    return "Still missed: " + ("; ".join(missed) if missed else "nothing that is known") + ".\n"
