"""docs/proof.md: what was named on the real recordings beside what is known of them, with pictures."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identification.diagnosis.search.selected import NAMED

from ..diagnose_real.score import fixed
from ..diagnose_real.sets import CASES
from .open_loop import worse_position
from .pictures import budget_picture, turn_picture
from .texts import ABOUT, INTRODUCTION, MOTOR_WORDS, OPEN_LOOP, SIMULATED

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


WAYS = {"product": "values stated", "bare": "no values stated"}
"""Who answered -> heading."""


def simulated_section(file: Path | None) -> str:
    """What was found again, by a file of `concealed.py --json`; without one, where to count it."""
    if file is None:
        return SIMULATED
    saved = json.loads(file.read_text())
    scores = {"product": saved} | {who: saved[who] for who in WAYS if who in saved}
    header = ["", *(WAYS[who] for who in scores)]
    rows = [[name, *(words(score) for score in scores.values())] for name, words in ROWS.items()]
    return f"{SIMULATED}\n{table(header, rows)}\n{otherwise(saved)}"


def _percent(key: str) -> Callable[[dict[str, Any]], str]:
    return lambda score: f"{100 * score[key]:.0f} %"


ROWS: dict[str, Callable[[dict[str, Any]], str]] = {
    "cases": lambda score: str(score["cases"]),
    "single effects large enough to be seen": lambda score: str(score["detectable"]),
    "of these, named, on the right joint, first": _percent("top1"),
    "of these, named or among the alternatives": _percent("with_alternatives"),
    "nothing missing, and something named": lambda score: (
        f"{score['false_alarms']} of {score['nothing_cases']} cases"
    ),
    "two effects: found": _percent("double_recall"),
    "two effects: right of what is named": _percent("double_precision"),
    "an effect without a model here: something else named": _percent("outside_misnamed"),
}
"""Row of the table -> its words."""


def otherwise(score: dict[str, Any]) -> str:
    """Singles that were called otherwise, cases without an effect that were named, each with its number."""
    called = [f"{truth} as {name} ({times})" for truth, name, times in score["confusion"]]
    text = "; ".join(called).replace("_", " ")
    return f"Of all strengths, called otherwise: {text or 'nothing'}.\n"


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
    parts += [section(given[key], picture) for key in ABOUT if key in given]
    if all(key in given for key in MOTOR):
        parts.append(motor_section(given, picture))
    parts += [known_section(answers), simulated_section(simulated)]
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
        ["longest diagnosis", longest(answers)],
    ]
    if figures["cpu_seconds_per_minute_set"]:
        arm = CASES[figures["cpu_seconds_per_minute_set"]].title
        rows.append(
            [
                "most for six joints",
                f"{figures['cpu_seconds_per_minute']:.1f} s of one core a minute of data ({arm})",
            ]
        )
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


def longest(answers: Sequence[Answer]) -> str:
    """The set that took longest, with the length of its recordings."""
    one = max(answers, key=lambda one: one["seconds"])
    return (
        f"{one['seconds']:.0f} s for {one['data_seconds']:.0f} s of {one['joints']} joints "
        f"({CASES[one['case']].title}; {one['process_seconds']:.0f} s of one core)"
    )


def section(one: Answer, picture: Callable[[str, str, str], str]) -> str:
    """One set: what is known, what was given, named, left and missed."""
    about, case = ABOUT[one["case"]], CASES[one["case"]]
    known = [
        [title(k), evidence(k), k["size"], verdict(k), k.get("found", k.get("near", ""))]
        for k in one["known"]
        if k["expected"] or k["named"]
    ]
    shown = picture(one["case"], f"Budget of the misfit, {case.title}", budget_picture(one, about.unit))
    parts = [f"## {about.heading}\n", shown, f"{about.what} Given: {case.prior}.\n"]
    if known:
        parts.append(table(["known effect", "known by", "known size", "", "found, or how near"], known))
    parts += [
        named_words(one),
        budget_words(one, about.unit),
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
    words = f"Position held out, {worse_position(found)}.\n"
    return f"{OPEN_LOOP}\n\n{table(['model', 'fitted run', 'held out'], rows)}\n{words}"


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


MOTOR = ("odrive_off", "odrive_on")
"""Its row with the ripple inside default filters, and the control."""

SWITCHED = ("odrive_nocomp_setpoint_given", "odrive_comp_setpoint_given")
"""Its rows that differ in the compensation alone, and in whose band the ripple lies."""


def motor_section(given: dict[str, Answer], picture: Callable[[str, str, str], str]) -> str:
    """The motor in its states: alike but for the compensation first, then all rows."""
    rows = [motor_row(one) for one in given.values() if one["case"].startswith("odrive")]
    drawn = {CASES[key].title: given[key] for key in (MOTOR[0], *SWITCHED) if key in given}
    alike = [given[key] for key in SWITCHED if key in given]
    text = " ".join(state_words(word, one) for word, one in zip(("Off", "On"), alike, strict=False))
    head = ["state", "band", "samples with harmonic 7 inside", "named", "probability", "size"]
    head += ["residual held out [A]"]
    return f"""## A motor whose cogging compensation was switched off and on

{MOTOR_WORDS}
{text}

{picture("cogging", "Current over one turn of the motor, and the independent map", turn_picture(drawn))}
{" ".join(seventh_words(one) for one in alike)}
Where the ripple is named in both states they differ by its amplitude, and not by its absence; other names
explain a part of it.

{table(head, rows)}
{band_words(given[MOTOR[1]])}

{picture("odrive_off", "Budget of the misfit, compensation off", budget_picture(given[MOTOR[0]], "A"))}"""


def seventh_words(one: Answer) -> str:
    """Harmonic 7 of what is left and of the map, over the turn."""
    row = one["over_a_turn"]
    wave = np.exp(-7j * np.array(row["angle"]))
    left, mapped = (2 * np.mean(wave * np.array(row[name])) for name in ("left", "map"))
    angle = np.degrees(np.angle(left / mapped))
    state = CASES[one["case"]].title.split(",")[1].strip()
    return f"Harmonic 7 left over the turn, {state}: {abs(left):.2f} A, {angle:+.0f}° from the map's."


def band_words(one: Answer) -> str:
    """Whether the control could have shown the ripple at all."""
    seen, band = one["over_a_turn"]["seen"], one["band"]
    inside = f"harmonic 7 is inside that band in {100 * seen:.0f} % of its samples"
    count = f"Default filters of the second row end at {band:.0f} Hz; {inside}."
    weak = (
        "So that nothing is named there is no proof that the ripple is gone: the third row has it, with the "
        "same current and default filters. "
    )
    return (
        f"{count} {weak if seen < 0.5 else ''}The two rows that differ in the compensation alone, with "
        "the same current in the same band, are those of the set current with cut-offs given. What is named "
        "there and cannot be, on a motor without a gear, is false."
    )


def state_words(state: str, one: Answer) -> str:
    """What was named in a state."""
    orders = [short(name) for name in one["named"] if name["effect"] == "torque_ripple"]
    other = [title(name) for name in one["named"] if name["effect"] != "torque_ripple"]
    text = [f"torque ripple, {'; '.join(orders)}"] if orders else []
    return f"**{state}: {'; '.join(text) or 'no ripple'} is named.**" + (
        f" Also named: {', '.join(other)}." if other else ""
    )


def short(name: dict[str, Any]) -> str:
    """Size of a finding on the motor, of a ripple without its two coefficients; its torque is a current."""
    size = name["size"]
    if name["effect"] == "torque_ripple":
        size = size[size.index("harmonic ") :]
    return size.replace("N m", "A")


def motor_row(one: Answer) -> list[str]:
    """State, names, probabilities, sizes, residual."""
    names = one["named"]
    return [
        CASES[one["case"]].title.removeprefix("motor, "),
        f"{one['band']:.0f} Hz",
        f"{100 * one['over_a_turn']['seen']:.0f} %",
        "<br>".join(title(name) for name in names) or "nothing",
        "<br>".join(percent(name["probability"]) for name in names),
        "<br>".join(short(name) for name in names),
        " ".join(gains(one)),
    ]
