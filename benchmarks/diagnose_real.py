"""Real arms with a plain prior: which of the effects that are known to be there are named, and what else is.

The prior is a bare description: no friction values, inertias not stated, except where somebody weighed them.
What is known of each set, and how, is in `parts/diagnose_real/known.py`; on controls every name is wrong.
Every row counts, with default filters and given ones. Each set is diagnosed again with what was named in its
model: nothing should be named then. `--keep FILE` has each answer as it is done, and a second run goes on.
"""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: times are those of one core

import numpy as np
from common import Kept, parser, save, show
from parts.diagnose_real.answer import answer
from parts.diagnose_real.score import WORDS, fixed, score
from parts.diagnose_real.sets import CASES, FOLDER
from parts.proof.page import write_pages


def known_table(answers: Sequence[dict[str, Any]]) -> None:
    """Each known effect: whether it is named, with what probability and size."""
    rows = []
    for one in answers:
        for known in one["known"]:
            if not known["expected"] and not known["named"]:
                continue
            row = [one["case"], known["effect"], known["joints"], known["how"], known["size"]]
            row += [WORDS[known["named"], known.get("right")], known.get("probability", np.nan)]
            rows.append([*row, known.get("found", known.get("near", "")), known["shown"]])
    header = ["set", "effect", "joints", "known by", "known size", "", "probability"]
    header += ["found, or how near", "shown"]
    show("Known effects", header, rows)


def names_table(answers: Sequence[dict[str, Any]]) -> None:
    """Every other name."""
    rows = []
    for one in answers:
        for name in (*one["named"], *one["undecided"]):
            if name["verdict"] != "known":
                row = [one["case"], name["verdict"], name["effect"], name["joints"], name["probability"]]
                rows.append([*row, name["size"], name["why"]])
    header = ["set", "verdict", "effect", "joints", "probability", "size", "why, or what else"]
    show("Other names", header, rows)


def again_table(answers: Sequence[dict[str, Any]]) -> None:
    """What is named again, with what was named in the model."""
    rows = []
    for one in answers:
        held = one["again"]
        if held:
            row = [one["case"], "yes" if fixed(one) else "no", held["held"], ", ".join(held["lost"])]
            rows.append([*row, "; ".join(held["named"])])
    show("Diagnosed again", ["set", "fixed point", "held", "no model holds", "named again"], rows)


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
    options.add_argument(
        "--keep", type=Path, metavar="FILE", help="answers stay in FILE, and are not asked again"
    )
    options.add_argument("--pages", type=Path, metavar="FILE.md", help="write the page of proof to FILE.md")
    chosen = options.parse_args()
    keys = chosen.only or [key for key, case in CASES.items() if case.quick or not chosen.quick]
    absent = [key for key in keys if not (FOLDER / CASES[key].folder).is_dir()]
    if absent:
        print(f"left out: {', '.join(absent)}: no recordings in {FOLDER}; set EXIDYN_DATA to their folder")
    answers, kept = [], Kept(chosen.keep)
    for key in keys:
        if key not in absent:
            name = f"{key}{', once' * chosen.quick}"
            answers.append(kept.of(name, lambda key=key: answer(key, twice=not chosen.quick)))
            report(answers[-1])
    if not answers:
        return
    if len(answers) > 1:
        tables(answers)
    figures = score(answers)
    show("Score", ["figure", "value"], [[name, words(value)] for name, value in figures.items()])
    save(chosen.json, figures | {"sets": answers})
    if chosen.pages:
        write_pages(chosen.pages, figures, answers)


def words(value: Any) -> Any:
    """A figure that is no number in words."""
    return str(value).lower() if isinstance(value, bool) else value


def report(one: dict[str, Any]) -> None:
    """All tables of a set."""
    tables([one])
    budget_table(one)
    if one["open_loop"]:
        rows = [[model, *errors.values()] for model, errors in one["open_loop"].items()]
        show("EMPS: position from recorded force, rms error [mm]", ["model", "train", "held out"], rows)


def tables(answers: Sequence[dict[str, Any]]) -> None:
    """The tables that some sets share."""
    for table in (known_table, names_table, again_table, gains_table):
        table(answers)


if __name__ == "__main__":
    main()
