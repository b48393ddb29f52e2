"""docs/proof.md: what was named on the real recordings beside what is known of them, with pictures."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from exidyn.identify.diagnosis.search.selected import NAMED

from ..diagnose_real.sets import CASES
from .motor import MOTOR, motor_section
from .pictures import budget_picture
from .simulated import simulated_section
from .texts import ABOUT, INTRODUCTION, OPEN_LOOP
from .words import Answer, gains, percent, table, title, verdict


def write_pages(
    path: Path, figures: dict[str, Any], answers: Sequence[Answer], simulated: Path | None
) -> None:
    """Write the page, and its pictures beside it in `pictures/`; with figures of simulated arms, if given."""
    given = {one["case"]: one for one in answers}
    folder = path.parent / "pictures"
    folder.mkdir(parents=True, exist_ok=True)

    def picture(name: str, title: str, content: str) -> str:
        (folder / f"proof-{name}.svg").write_text(content, encoding="utf-8")
        return f"![{title}](pictures/proof-{name}.svg)\n"

    parts = [INTRODUCTION, summary(figures, answers)]
    if all(key in given for key in MOTOR):
        parts.append(motor_section(given, picture))
    parts += [section(given[key], picture) for key in ABOUT if key in given]
    parts += [simulated_section(simulated)]
    path.write_text("\n".join(parts), encoding="utf-8")
    print(f"\npage in {path}")


def summary(figures: dict[str, Any], answers: Sequence[Answer]) -> str:
    """The figures, and each known effect in a line."""
    rows = [
        ["known effects named", f"{figures['known_named']} of {figures['known']}"],
        [
            "of these, size off",
            str(figures["sizes_off"]),
        ],
        ["false names", str(figures["false_names"])],
        ["unverified names", str(figures["unverified"])],
        ["not named, though another name for it has 90 % or more", str(figures["named_otherwise"])],
        [
            "joints with a larger residual held out than before, by more than 2 %",
            str(figures["worse_held_out"]),
        ],
        ["longest diagnosis", longest(answers)],
    ]
    known = [(one, known) for one in answers for known in one["known"] if known["counted"]]
    lines = [
        [CASES[one["case"]].title, title(known), known["how"], known["size"], verdict(known)]
        for one, known in known
    ]
    return f"{table(['', ''], rows)}\n{table(['set', 'effect', 'known by', 'known size', ''], lines)}"


def longest(answers: Sequence[Answer]) -> str:
    """The set that took longest, with the length of its recordings."""
    one = max((one for one in answers if CASES[one["case"]].counted), key=lambda one: one["seconds"])
    return (
        f"{one['seconds']:.0f} s for {one['data_seconds']:.0f} s of {one['joints']} joints "
        f"({CASES[one['case']].title}; {one['process_seconds']:.0f} s of one core)"
    )


def section(one: Answer, picture: Callable[[str, str, str], str]) -> str:
    """One set: what is known, what was given, named, left and missed."""
    about, case = ABOUT[one["case"]], CASES[one["case"]]
    known = [
        [title(k), k["how"], k["size"], verdict(k), k.get("found", k.get("near", ""))]
        for k in one["known"]
        if k["counted"] or k["named"]
    ]
    parts = [f"## {about.heading}\n", f"{about.what} Given: {case.prior}.\n"]
    if known:
        parts.append(table(["known effect", "known by", "known size", "", "found, or how near"], known))
    parts += [
        named_words(one),
        budget_words(one, about.unit),
        picture(one["case"], f"Budget of the misfit, {case.title}", budget_picture(one, about.unit)),
    ]
    if one["open_loop"]:
        parts.append(open_loop_words(one["open_loop"]))
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


def open_loop_words(found: dict[str, dict[str, float]]) -> str:
    """Simulation from recorded force alone."""
    rows = [[model, *(f"{error:.2f}" for error in errors.values())] for model, errors in found.items()]
    return f"{OPEN_LOOP}\n\n{table(['model', 'fitted run', 'held out'], rows)}"


def again_words(one: Answer) -> str:
    """What a second diagnosis finds with the findings in the model."""
    if not one["again"]:
        return ""
    held, total, more = len(one["again"]["held"]), len(one["named"]), one["again"]["named"]
    if not held:
        return "Not diagnosed again: what was named is nothing that a model's columns can hold.\n"
    rest = "" if held == total else "; the others are nothing that a model's columns can hold"
    text = f"Diagnosed again with {held} of the {total} named in the model{rest}"
    return f"{text}: {'; '.join(more) if more else 'nothing'} named.\n"


def missed_words(one: Answer) -> str:
    """What is still missed, plainly."""
    missed = [
        f"{title(k)} ({k['how']}) is not named" for k in one["known"] if k["counted"] and not k["named"]
    ]
    again = one["again"]["same"] if one["again"] else []
    missed += [f"with it in the model, {name} is named once more" for name in again]
    missed += [f"left on {text}" for text in one["left"]]
    return "Still missed: " + ("; ".join(missed) if missed else "nothing that is known") + ".\n"
