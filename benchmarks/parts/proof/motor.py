"""The section of docs/proof.md on the motor whose cogging compensation was switched off and on."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..diagnose_real.sets import CASES
from .page import Answer, gains, percent, table, title
from .pictures import budget_picture, turn_picture
from .texts import MOTOR_WORDS

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
