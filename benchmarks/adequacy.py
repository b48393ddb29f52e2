"""Adequate before certain: no name where nothing of the vocabulary fits, and every name where it does.

30 correct recordings, of real arms and simulated ones, and 30 of them made wrong are diagnosed. A name on a
wrong recording is false, unless it describes the mistake or is named on the correct recording too. A name on
a correct recording is lost if the gate withholds it. P is the left-out residual over the torque of all
joints, X the worst joint's residual over that with parameters of its own. Thresholds from half of the arms
are judged on the other half, beside those of exidyn and the worst joint's share alone. --keep FILE resumes.
"""

import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy

import time

import numpy as np
from common import Kept, parser, save, show
from parts.adequacy.mistakes import MISTAKES
from parts.adequacy.recordings import CORRECT, FOLDER

from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.search.selected import NAMED

Answer = dict[str, Any]
FEW, CONTROLS = ("emps", "dvrk", "pendubot"), ("dvrk", "panda")
"""Arms with too few joints for most mistakes; arms on which every name is false, so that none can be lost."""
QUICK = ("dvrk_psm fourier_test", "position of joint 2 negated")


def cases(quick: bool) -> list[tuple[str, str]]:
    """Name of the recording, and mistake; "" where it is correct."""
    names = [name for name in CORRECT if name.startswith(("cobot", "kr270")) or FOLDER.exists()]
    if quick:
        return [(QUICK[0], ""), QUICK] if QUICK[0] in names else [("cobot 1", "")]
    many, mistakes = [name for name in names if not name.startswith(FEW)], list(MISTAKES)
    wrong = [(many[7 * k % len(many)], mistakes[k % len(mistakes)]) for k in range(30)]
    return [*((name, "") for name in names), *wrong]


def answer(name: str, mistake: str) -> Answer:
    """Names with and without the gate, and the adequacy."""
    log, began = CORRECT[name](), time.process_time()
    log = MISTAKES[mistake][0](log) if mistake else log
    found = diagnose(log.model, [("identify", log.run)], as_recorded=True)
    fit = found.adequacy
    assert fit is not None
    sure = [f for f in found.undecided if f.probability >= NAMED and f.proven and not f.alone]
    withheld = [finding for finding in sure if fit.fails(finding.joints)]
    return {
        "names": [(f.effect, f.joints) for f in found.findings],
        "withheld": [(f.effect, f.joints) for f in withheld],
        "P": fit.pooled_share,
        "X": float(np.nanmax(fit.shares / fit.shares_alone)),
        "worst": float(np.nanmax(fit.shares)),
        "failing": fit.failing,
        "misfits": len(fit.misfits),
        "seconds": time.process_time() - began,
    }


def judged(answers: dict[tuple[str, str], Answer], failed: Callable[[Answer], bool] | None) -> Answer:
    """Figures with a gate of whole recordings, or with that of exidyn."""
    false, lost, total, alarms, missed = 0, 0, 0, 0, 0
    for (name, mistake), one in answers.items():
        every, fails = [*one["names"], *one["withheld"]], failed(one) if failed else bool(one["failing"])
        names = one["names"] if failed is None else [] if fails else every
        if mistake:
            right = answers.get((name, ""), {"names": [], "withheld": []})
            known = [*right["names"], *right["withheld"]]
            false += sum(n not in known and n[0] not in MISTAKES[mistake][1] for n in names)
            missed += not fails
            continue
        alarms += fails
        if not name.startswith(CONTROLS):
            lost, total = lost + len(every) - len(names), total + len(every)
    count = sum(bool(mistake) for _, mistake in answers)
    return {
        "false_names_per_wrong": false / count if count else None,
        "names_lost_percent": 100.0 * lost / total if total else None,
        "names_on_correct": total,
        "correct_that_fail": alarms,
        "wrong_that_pass": missed,
        "correct": len(answers) - count,
        "wrong": count,
    }


def gates(answers: dict[tuple[str, str], Answer]) -> dict[str, Callable[[Answer], bool] | None]:
    """Gates whose thresholds are the largest values of correct recordings, and those of exidyn."""
    right = [one for (_, mistake), one in answers.items() if not mistake]
    p, x, worst = (max((one[key] for one in right), default=np.inf) for key in ("P", "X", "worst"))
    return {
        "none": lambda one: False,
        f"worst joint's share > {worst:.2f}": lambda one: one["worst"] > worst,
        f"P > {p:.3f} or X > {x:.2f}": lambda one: one["P"] > p or one["X"] > x,
        "of exidyn, by joint": None,
    }


def tables(answers: dict[tuple[str, str], Answer]) -> Answer:
    """Print all recordings and gates; the figures of exidyn's gate on all recordings."""
    rows = list[Sequence[Any]]()
    for (name, mistake), one in answers.items():
        counts = [len(one[key]) for key in ("names", "withheld", "failing")]
        rows.append(
            [name, mistake, *(one[key] for key in ("P", "X", "worst", "misfits", "seconds")), *counts]
        )
    head = ["recording", "mistake", "P", "X", "worst share", "misfits", "CPU s", "named", "withheld", "fail"]
    show("Recordings", head, rows)
    arms = sorted({name.split()[0] for name, _ in answers})
    half = {key: one for key, one in answers.items() if key[0].split()[0] in arms[::2]}
    other = {key: one for key, one in answers.items() if key not in half}
    compared = [[name, *judged(other, gate).values()] for name, gate in gates(half).items()]
    figures = judged(answers, None)
    show("Thresholds from half of the arms, on the other half", ["gate", *figures], compared)
    without = judged(answers, gates(half)["none"])["false_names_per_wrong"]
    return figures | {"false_names_without_gate": without, "halves": compared}


def main() -> None:
    taken = parser(__doc__.splitlines()[0])
    taken.add_argument("--keep", type=Path, metavar="FILE", help="keep answers in FILE, and go on from them")
    chosen = taken.parse_args()
    kept, answers = Kept(chosen.keep), {}
    for name, mistake in cases(chosen.quick):
        answers[name, mistake] = kept.of(f"{name}, {mistake or 'correct'}", partial(answer, name, mistake))
    figures = tables(answers)
    show("Adequacy", ["figure", "value"], [[k, v] for k, v in figures.items() if k != "halves"])
    save(chosen.json, figures | {"answers": [[*key, one] for key, one in answers.items()]})


if __name__ == "__main__":
    main()
