"""docs/proof.md: what was named on the real recordings beside what is known of them, with pictures."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from exidyn.identify.diagnosis.search.selected import NAMED

from ..diagnose_real.sets import CASES
from .pictures import budget_picture, turn_picture

Answer = dict[str, Any]

MOTOR = ("odrive_off", "odrive_on")
"""The motor's rows that count, which come first."""
SWITCHED = ("odrive_nocomp_setpoint_given", "odrive_comp_setpoint_given")
"""Its rows that differ in the compensation alone, and in whose band the ripple lies."""
MOTOR_WORDS = """\
One brushless motor without gear or load (ODrive; recordings of gchenfc, MIT), spun up and reversed. In one
state the drive adds a map of its cogging to the current; in the other it does not. The map is the current
that holds the motor still at 2048 angles: harmonics 7 (0.862 A), 28 (0.560 A), 14 (0.349 A), 36 (0.290 A)
and 12 (0.263 A) of its turn. The set current contains the ripple with compensation off, and is nearly
without it with compensation on, as the drive adds the map afterwards; the measured current contains it in
both states. A fit with given harmonics leaves 0.38 A of harmonic 7 in the set current with compensation on,
out of line with the map. Set current, the same cut-offs in both states (torque 60 Hz, position 80 Hz):"""


class About(NamedTuple):
    """A set on the page.

    Attributes:
        heading: Of its section.
        what: Machine and recordings, in sentences.
        unit: Of its misfit.
    """

    heading: str
    what: str
    unit: str = "N m"


ABOUT = {
    "emps": About(
        "EMPS: a sliding axis with a ball screw",
        "The benchmark of Janot, Gautier and Brunot (2019): 1 kHz, 25 s to fit and 25 s with pulses of "
        "force held out. Force is recorded. Its authors' second model brakes differently in the two "
        "directions.",
        "N",
    ),
    "tx40": About(
        "Stäubli TX40",
        "Six joints, one run of 9 s at 1 kHz, joint torque (figaroh-examples): the first 60 % fitted, the "
        "rest held out. Motor 6 turns with joints 5 and 6, and the sizes of that are published.",
    ),
    "panda": About(
        "Franka Panda: a control",
        "Seven joints, 21 s at 1 kHz (Gaz and others, 2019), torque from sensors behind the gears, which "
        "hide most of what motors and gears do: two thirds fitted, one held out. Nothing stands out in "
        "it, so every name would be wrong.",
    ),
    "kr300": About(
        "KUKA KR300",
        "Six joints, 300 kg class, six runs of 10 s at 250 Hz on three days (Weigand and others), motor "
        "torque: four fitted, two held out. A second encoder behind the gears of J1 to J3 shows by how "
        "much they bend, and so their stiffness.",
    ),
    "kr300_drawn": About(
        "KUKA KR300 with its links as drawn",
        "The same runs; now the masses of the CAD drawing are stated to 10 %, which have neither the gas "
        "counterbalance of J2 nor the tool. The tool is given as a body of unknown mass. Without stated "
        "masses a balancer may be a mass.",
    ),
    "ur10e": About(
        "UR10e",
        "Six joints, motor currents at 100 Hz (Mamedov and Mikhel): five runs fitted, two of other "
        "motions held out. Drive gains are published ones, to 10 %.",
    ),
    "ur10e_loaded": About(
        "UR10e with a weighed load that is not stated",
        "The prior is what exidyn identified from the five runs without a load. The run that is diagnosed "
        "has 2.805 kg on the flange; the one held out another motion with the same body.",
    ),
    "kscale": About(
        "Feetech STS3215: a servo that swings weighed masses",
        "One joint, 100 Hz, four masses on an arm of 100 mm (K-Scale Labs), voltage on the motor: three "
        "motions with each mass fitted, one held out. Gravity on each is known from scales and ruler.",
    ),
}

INTRODUCTION = """# Proof on real recordings

`python benchmarks/diagnose_real.py --pages docs/proof.md` makes this page and its pictures. It diagnoses
public recordings not made by this project, with what a user has to begin with: a bare description,
no friction values, inertias not stated, all filters chosen from the data. The recordings are not part of
the repository (`EXIDYN_DATA` names their folder).

An effect is *known* if the experiment shows it without a diagnosis: it was switched off and on, weighed,
measured by a second encoder, mapped by another method, published, found by plain least squares with and
without it, or named by the index of the recordings. It is *named* from a probability of 90 % on. A name is
*false* if the source excludes it or would have reported it (contact, delay, tilt, load; a gain where torque
was recorded), if the set is a control, or if it is named once more with what was named in the model. Its
size is *off* if it is not the known one within two of its standard deviations. Other names are *unverified*:
nothing is known for or against them. What is *undecided* is in the fit without a name. Misfit is the root
mean square of what the best fit without findings leaves of runs held out.
"""

SIMULATED = """## Simulated arms

What was concealed from the model of simulated arms, and how much of it is found again, is counted by
[benchmarks/concealed.py](../benchmarks/concealed.py).
"""


def write_pages(path: Path, figures: dict[str, Any], answers: Sequence[Answer]) -> None:
    """Write the page, and its pictures beside it in `pictures/`."""
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
    parts += [SIMULATED]
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


def motor_section(given: dict[str, Answer], picture: Callable[[str, str, str], str]) -> str:
    """The motor in its states: alike but for the compensation first, then the rows that count."""
    rows = [motor_row(one) for one in given.values() if one["case"].startswith("odrive")]
    drawn = {CASES[key].title: given[key] for key in (MOTOR[0], *SWITCHED) if key in given}
    alike = [given[key] for key in SWITCHED if key in given]
    text = " ".join(state_words(word, one) for word, one in zip(("Off", "On"), alike, strict=False))
    head = [
        "state",
        "band",
        "samples with harmonic 7 inside",
        "named",
        "probability",
        "size",
        "residual held out [A]",
    ]
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
    count = f"The first two rows count: default filters. Those of the second end at {band:.0f} Hz; {inside}."
    weak = (
        "So that nothing is named there is no proof that the ripple is gone: the third row has it, with the "
        "same current and default filters. "
    )
    return (
        f"{count} {weak if seen < 0.5 else ''}The two rows that differ in the compensation alone, with "
        "the same current in the same band, are those of the set current with cut-offs given. What is named "
        "there and cannot be, on a motor without a gear, is false; it is not counted, for the filters are "
        "not the default ones."
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


def gains(one: Answer) -> list[str]:
    """Residual before and after, joint by joint."""
    found = one["improvement"]
    return (
        [f"{a:.3g} → {b:.3g}" for a, b in zip(found["before"], found["after"], strict=True)] if found else []
    )


OPEN_LOOP = """\
Models integrated from the recorded force alone, with nothing of the recorded motion but its first place:
error of the position, root mean square [mm]. The page that comes with the recordings has 6.75 and 9.20 for
the published parameters, by another integration."""


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


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
