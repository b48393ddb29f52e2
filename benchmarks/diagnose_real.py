"""Real arms with a plain prior: which of the effects that are known to be there are named, and what else is.

The prior is a bare description: no friction values, inertias not stated, except where somebody weighed them.
Default filters. What is known of each set, and how, is in `parts/diagnose_real/known.py`; on controls every
name is wrong. Each set is diagnosed again with what was named in its model: none of it may be named twice.
"""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: times are those of one core

import numpy as np
from common import parser, save, show
from parts.diagnose_real.answer import answer
from parts.diagnose_real.sets import CASES, FOLDER
from parts.proof.page import write_pages

from exidyn.identify.diagnosis.search.selected import NAMED

WORSE = 1.02
"""Residual held out, after over before, from which a joint counts as worse: less is chance."""


def score(answers: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The figures: of the sets that count."""
    counted = [one for one in answers if CASES[one["case"]].counted]
    known = [known for one in counted for known in one["known"] if known["counted"]]
    verdicts = [name["verdict"] for one in counted for name in one["named"]]
    return {
        "known": len(known),
        "known_named": sum(one["named"] for one in known),
        "known_named_percent": 100.0 * sum(one["named"] for one in known) / max(len(known), 1),
        "sizes_off": sum(one.get("right") is False for one in known),
        "false_names": verdicts.count("false")
        + sum(len(one["again"]["same"]) for one in counted if one["again"]),
        "false_names_not_counted": sum(
            n["verdict"] == "false" for one in answers if one not in counted for n in one["named"]
        ),
        "unverified": verdicts.count("unverified"),
        "named_otherwise": sum(n["instead"] >= NAMED for one in counted for n in one["undecided"]),
        "worse_held_out": sum(len(worse(one)) for one in counted),
        "seconds": max((one["seconds"] for one in counted), default=0.0),
        "process_seconds": max((one["process_seconds"] for one in counted), default=0.0),
    }


WORDS = {
    (True, True): "named",
    (True, None): "named",
    (True, False): "named, SIZE OFF",
    (False, None): "MISSED",
}
"""Whether a known effect is named, and whether its size is right -> in a table."""


def worse(one: dict[str, Any]) -> list[int]:
    """Joints, from 0, whose residual held out is larger after than before."""
    if not one["improvement"]:
        return []
    before, after = (np.array(one["improvement"][key]) for key in ("before", "after"))
    return np.flatnonzero(after > WORSE * before).tolist()


def known_table(answers: Sequence[dict[str, Any]]) -> None:
    """Each known effect: whether it is named, with what probability and size."""
    rows = []
    for one in answers:
        for known in one["known"]:
            if not known["counted"] and not known["named"]:
                continue
            row = [one["case"], known["effect"], known["joints"], known["how"], known["size"]]
            row += [WORDS[known["named"], known.get("right")], known.get("probability", np.nan)]
            rows.append(
                [*row, known.get("found", known.get("near", "")), "" if known["counted"] else "not counted"]
            )
    header = [
        "set",
        "effect",
        "joints",
        "known by",
        "known size",
        "",
        "probability",
        "found, or how near",
        "",
    ]
    show("Known effects", header, rows)


def names_table(answers: Sequence[dict[str, Any]]) -> None:
    """Every other name, and what is named twice."""
    rows = []
    for one in answers:
        count = "" if CASES[one["case"]].counted else "not counted"
        for name in (*one["named"], *one["undecided"]):
            if name["verdict"] != "known":
                row = [one["case"], name["verdict"], name["effect"], name["joints"], name["probability"]]
                rows.append([*row, name["size"], name["why"], count])
        for name in one["again"]["same"] if one["again"] else ():
            rows.append([one["case"], "false", name, "", np.nan, "", "it is in the model already", count])
    header = ["set", "verdict", "effect", "joints", "probability", "size", "why, or what else", ""]
    show("Other names", header, rows)


def gains_table(answers: Sequence[dict[str, Any]]) -> None:
    """Held-out residual after over before, per joint, and the time that it took."""
    most = max(one["joints"] for one in answers)
    rows = []
    for one in answers:
        found = one["improvement"] or {"before": [np.nan] * one["joints"], "after": [np.nan] * one["joints"]}
        ratio = np.array(found["after"]) / np.array(found["before"])
        times = [one["band"] or np.nan, one["seconds"], one["process_seconds"], one["data_seconds"]]
        rows.append([one["case"], *ratio, *[np.nan] * (most - len(ratio)), *times])
    header = ["set", *(f"J{j + 1}" for j in range(most)), "band Hz", "wall s", "process s", "data s"]
    show("Residual held out, after over before; band; time of the diagnosis and of its data", header, rows)


def budget_table(one: dict[str, Any]) -> None:
    """Where the misfit goes, per joint [%]."""
    if not one["budget"]:
        return
    shares = [[s["what"], *(100 * np.array(s["shares"]))] for s in one["budget"]["shares"]]
    rows = [row for row in shares if max(row[1:]) >= 0.5]
    header = [f"{one['case']}: budget %", *(f"J{j + 1}" for j in range(one["joints"]))]
    show("", header, [[row[0], *np.round(row[1:])] for row in rows])


def main() -> None:
    options = parser(__doc__.splitlines()[0], CASES)
    options.add_argument("--pages", type=Path, metavar="FILE.md", help="write the page of proof to FILE.md")
    options.add_argument(
        "--simulated", type=Path, metavar="FILE", help="what concealed.py --json wrote, for the page"
    )
    chosen = options.parse_args()
    keys = chosen.only or [key for key, case in CASES.items() if case.quick or not chosen.quick]
    absent = [key for key in keys if not (FOLDER / CASES[key].folder).is_dir()]
    if absent:
        print(f"left out: {', '.join(absent)}: no recordings in {FOLDER}; set EXIDYN_DATA to their folder")
    answers = [answer(key, again=not chosen.quick) for key in keys if key not in absent]
    if not answers:
        return
    report(answers)
    figures = score(answers)
    save(chosen.json, figures | {"sets": answers})
    if chosen.pages:
        write_pages(chosen.pages, figures, answers, chosen.simulated)


def report(answers: Sequence[dict[str, Any]]) -> None:
    """All tables, and the score."""
    known_table(answers)
    names_table(answers)
    gains_table(answers)
    for one in answers:
        budget_table(one)
        if one["open_loop"]:
            rows = [[model, *errors.values()] for model, errors in one["open_loop"].items()]
            show("EMPS: position from recorded force, rms error [mm]", ["model", "train", "held out"], rows)
    show("Score", ["figure", "value"], [[name, value] for name, value in score(answers).items()])


if __name__ == "__main__":
    main()
