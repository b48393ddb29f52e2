"""Scores and tables of the real arms."""

from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np
from common import show
from diagnose_real_answer import Answer, Named
from diagnose_real_belief import TOLERANCE


def bodies_table(answers: Sequence[Answer]) -> dict[str, Any]:
    """Hidden payloads: the mass that was found."""
    rows, errors = [], []
    for one in answers:
        found = one.right
        value, std = (found.value, found.std) if found else (np.nan, np.nan)
        errors.append(100 * (value / one.truth - 1))
        rows.append([one.question.arm, one.truth, value, std, errors[-1], words(one.others()), *worst(one)])
    header = ["payload hidden", "true [kg]", "found [kg]", "std [kg]", "error %", "besides", *WORST]
    show("Payload that the belief does not know of", header, rows)
    return {
        "payload": [
            {"arm": one.question.arm, "mass": one.truth, "error_percent": error, "first": first(one)}
            for one, error in zip(answers, errors, strict=True)
        ]
    }


def taken_table(answers: Sequence[Answer], nothing: Sequence[Answer]) -> dict[str, Any]:
    """Terms taken out of the belief: whether they are named, and what else is."""
    rows = []
    for one in answers:
        joint = one.question.joint
        strange = new_names(one, nothing)
        besides = "-" if strange is None else words(strange)
        row = [one.question.arm, one.question.effect, f"J{joint + 1}", one.truth, one.value, one.said]
        rows.append([*row, one.before[joint], one.after[joint], besides, one.seconds])
    header = ["arm", "taken out", "", "believed", "found", "", "before", "after", "new names besides", "s"]
    show("Terms taken out of the belief (residual of the joint over noise, held out)", header, rows)
    return {"taken_out": counted(answers, nothing), "seconds": [one.seconds for one in answers]}


def counted(answers: Sequence[Answer], nothing: Sequence[Answer]) -> dict[str, Any]:
    """Table of counts, an arm and effect a row."""
    rows, figures = [], {}
    for (arm, effect), group in groupby(answers, lambda one: (one.question.arm, one.question.effect)):
        every = list(group)
        named = sum(one.right is not None for one in every)
        near = sum(one.right is None and one.near is not None for one in every)
        strange = [len(new) for one in every if (new := new_names(one, nothing)) is not None]
        figures[f"{arm} {effect}"] = scores = {
            "asked": len(every),
            "named": named,
            "as_akin": near,
            "missed": len(every) - named - near,
            "new_names": sum(strange) if strange else None,
            "found_over_believed": median([one.value / one.truth for one in every]),
            "residual_over_usual": median([over_usual(one, nothing) for one in every]),
        }
        rows.append([arm, effect, *scores.values()])
    title = "Terms taken out, counted (medians; usual: with nothing taken out)"
    show(title, ["arm", "taken out", *(name.replace("_", " ") for name in scores)], rows)
    return figures


def new_names(one: Answer, nothing: Sequence[Answer]) -> list[Named] | None:
    """Findings that are neither right nor found with nothing taken out; None where that was not asked."""
    own = [other for other in nothing if other.question.arm == one.question.arm]
    usual = {place(found) for other in own for found in other.findings}
    return [found for found in one.others() if place(found) not in usual] if own else None


def over_usual(one: Answer, nothing: Sequence[Answer]) -> float:
    """Residual of the joint over that with nothing taken out, with findings; NaN if that was not asked."""
    joint = one.question.joint
    runs = one.question.arm, one.question.asked
    same = [other for other in nothing if (other.question.arm, other.question.asked) == runs]
    return float(one.after[joint] / same[0].after[joint]) if same else float("nan")


def median(values: Sequence[float]) -> float | None:
    """Of those that are numbers; None where none is."""
    known = [value for value in values if np.isfinite(value)]
    return float(np.median(known)) if known else None


def nothing_table(answers: Sequence[Answer]) -> dict[str, Any]:
    """What is found with nothing taken out, and whether it is on other runs."""
    figures = {}
    for arm, group in groupby(answers, lambda one: one.question.arm):
        sets = list(group)
        places = dict.fromkeys(place(f) for one in sets for f in one.findings)
        rows = []
        for where in places:
            values = [next((f for f in one.findings if place(f) == where), None) for one in sets]
            unit = next(f.unit for f in values if f)
            rows.append([*where_words(where), unit, *(f"{f.value:.3g}" if f else "-" for f in values)])
        rows.append(["unexplained", "", "", *(joints_words(one.unexplained) or "-" for one in sets)])
        for label, share in (("before", lambda one: one.before), ("after", lambda one: one.after)):
            said = [" ".join(f"{value:.1f}" for value in share(one)) for one in sets]
            rows.append([f"residual over noise {label}", "", "", *said])
        header = ["found", "where", "unit", *(f"runs {k + 1}" for k in range(len(sets)))]
        show(f"{arm}: nothing taken out", header, rows)
        held = sum(all(any(place(f) == where for f in one.findings) for one in sets) for where in places)
        figures[arm] = {
            "found": [[list(place(f)) for f in one.findings] for one in sets],
            "on_all_runs": held,
        }
    return {"nothing_taken_out": figures}


def scatter_table(spread: dict[str, dict[str, np.ndarray]]) -> dict[str, Any]:
    """How far fits to single runs differ, beside the tolerance of the belief."""
    width = max(len(shares) for arm in spread.values() for shares in arm.values())
    rows = [
        [arm, effect, TOLERANCE[effect], *shares, *[np.nan] * (width - len(shares))]
        for arm, effects in spread.items()
        for effect, shares in effects.items()
    ]
    header = ["arm", "of", "tolerance", *(f"J{j + 1}" for j in range(width))]
    show("Scatter of fits to single runs, standard deviation over mean", header, rows)
    return {"scatter": spread}


WORST = ("worst joint", "before", "after", "s")


def worst(one: Answer) -> list[Any]:
    """The joint with the largest residual before, before and after over noise, and seconds."""
    joint = int(np.argmax(one.before))
    return [f"J{joint + 1}", one.before[joint], one.after[joint], one.seconds]


def first(one: Answer) -> bool:
    """Whether what was taken out is the first finding."""
    return bool(one.findings) and one.findings[0] is one.right


def place(found: Named) -> tuple[str, tuple[int, ...]]:
    """Effect and joints."""
    return found.effect, found.joints


def where_words(where: tuple[str, tuple[int, ...]]) -> list[str]:
    """Effect and joints in words, two cells."""
    return [where[0], joints_words(where[1])]


def joints_words(joints: Sequence[int]) -> str:
    """J2 J3; nothing for none."""
    return " ".join(f"J{joint + 1}" for joint in joints)


def words(findings: Sequence[Named]) -> str:
    """Findings in words; a dash for none."""
    return ", ".join(" ".join(where_words(place(one))).strip() for one in findings) or "-"
