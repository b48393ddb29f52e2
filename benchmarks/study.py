"""Study: arms with something concealed, named in less motion than by the best fixed programme?"""

import os
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from multiprocessing import get_context
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy

import numpy as np
from common import Kept, parser, save, show
from parts.study.answer import Answer
from parts.study.best import best_programme
from parts.study.case import Case, others, scored
from parts.study.faults import resumed
from parts.study.memory import peak_gb
from parts.study.programme import Programme, Run, answered, motions, words
from parts.study.servo import SUBSETS, of_subset
from parts.study.studies import MINUTES, QUICK, studied

HANDS = 60.0
"""For a body to be hung on or taken off [s]."""


def by_programme(case: Case, programme: Programme, folder: Path) -> dict[str, Any]:
    """An answer as plain values."""
    return asdict(answered(case, programme, folder))


def by_study(case: Case, folder: Path, shared: Path, minutes: float) -> dict[str, Any]:
    """The same of a study."""
    return asdict(studied(case, folder, shared, minutes))


class Work:
    """Work in several processes, and what was done of it before."""

    def __init__(self, pool: ProcessPoolExecutor, kept: Kept, shared: Path) -> None:
        self.pool, self.kept, self.shared = pool, kept, shared

    def asked(self, pairs: Sequence[tuple[Case, Programme]]) -> list[Answer]:
        """What programmes say of arms."""
        names = [f"{case.kind}, {case.seed}: {words(programme)}" for case, programme in pairs]
        new = {name: pair for name, pair in zip(names, pairs, strict=True) if name not in self.kept.found}
        futures = {name: self.pool.submit(by_programme, *pair, self.shared) for name, pair in new.items()}
        for name, future in futures.items():
            self.kept.put(name, future.result())
        return [Answer.read(dict(self.kept.found[name])) for name in names]

    def studies(self, cases: Sequence[Case], folder: Path, minutes: float) -> list[Answer]:
        """What studies say of them."""
        names = [f"study of {case.kind}, {case.seed}" for case in cases]
        futures = {
            name: self.pool.submit(by_study, case, folder / name, self.shared, minutes)
            for name, case in zip(names, cases, strict=True)
            if name not in self.kept.found
        }
        for name, future in futures.items():
            self.kept.put(name, future.result())
        return [Answer.read(dict(self.kept.found[name])) for name in names]


def compared(cases: Sequence[Case], study: Sequence[Answer], fixed: Sequence[Answer]) -> dict[str, Any]:
    """Study and programme by names, accuracy and motion; motion where both are right and accurate."""
    every = list(zip(cases, study, fixed, strict=True))
    both = [(one, other) for case, one, other in every if one.suffices(case) and other.suffices(case)]
    motion = [one.motion / other.motion for one, other in both]
    time = [(one.motion + HANDS * one.hands) / (other.motion + HANDS * other.hands) for one, other in both]
    return {
        "arms": len(cases),
        "right": sum(one.right(case) for case, one, _ in every) / len(every),
        "fixed_right": sum(one.right(case) for case, _, one in every) / len(every),
        "suffices": sum(one.suffices(case) for case, one, _ in every) / len(every),
        "fixed_suffices": sum(one.suffices(case) for case, _, one in every) / len(every),
        "false_names": sum(len(one.found - case.concealed) for case, one, _ in every),
        "fixed_false_names": sum(len(one.found - case.concealed) for case, _, one in every),
        "false_decided": sum(one.decided and not one.right(case) for case, one, _ in every),
        "motion_over_best_fixed": float(np.mean(motion)) if both else None,
        "time_over_best_fixed": float(np.mean(time)) if both else None,
        "compared": len(both),
        "motion_seconds": float(np.mean([one.motion for one in study])),
        "fixed_motion_seconds": float(np.mean([one.motion for one in fixed])),
        "error": _median([one.error for case, one, _ in every if not case.alike]),
        "fixed_error": _median([one.error for case, _, one in every if not case.alike]),
    }


def _median(errors: Sequence[float]) -> float:
    return float(np.median(errors)) if errors else float("nan")


def arms(given: Any, folder: Path, kept: Kept) -> dict[str, Any]:
    """Simulated arms: the best programme is searched on some, and compared with studies of others."""
    shared = folder / "shared"
    motions(shared)
    cases, minutes = (scored()[:1], QUICK) if given.quick else (scored()[: given.arms], MINUTES)
    with ProcessPoolExecutor(given.workers, get_context("spawn")) as pool:
        work = Work(pool, kept, shared)
        if given.quick:
            best: Programme = (Run("short excitation", False), Run("chirp", True))
            enough = float("nan")
        else:
            best, enough = best_programme(others(), work.asked)
        study = work.studies(cases, folder, minutes)
        fixed = work.asked([(case, best) for case in cases])
    rows = [
        [case.kind, _said(case, one), one.motion, one.error, _said(case, other), other.motion, other.error]
        for case, one, other in zip(cases, study, fixed, strict=True)
    ]
    head = ["arm", "study", "motion [s]", "error", "programme", "motion [s]", "error"]
    show(f"Studies beside the best programme: {words(best)}", head, rows)
    return {"best_fixed": words(best), "best_fixed_suffices_for_others": enough} | compared(
        cases, study, fixed
    )


def _said(case: Case, answer: Answer) -> str:
    right = "right" if answer.right(case) else f"WRONG: {', '.join(sorted(e for e, _ in answer.found))}"
    return f"{right}{', decided' if answer.decided else ''}"


def servo(given: Any, folder: Path, kept: Kept) -> dict[str, Any]:
    """Recordings of a servo, in subsets."""
    names = list(SUBSETS)[:1] if given.quick else list(SUBSETS)
    found = {
        name: kept.of(f"servo, {name}", lambda name=name: of_subset(name, folder / f"servo, {name}"))
        for name in names
    }
    return {
        "servo": found,
        "servo_right": sum(one["right"] for one in found.values()) / len(found),
        "servo_false_decided": sum(one["false_decided"] for one in found.values()),
    }


def faults(given: Any, folder: Path, kept: Kept) -> dict[str, Any]:
    """Stops of every kind, and whether the study goes on."""
    place = folder / "faults"
    place.mkdir(exist_ok=True)
    found = kept.of("faults", lambda: resumed(place))
    return {"faults": found, "faults_resumed": sum(found.values()), "faults_tried": len(found)}


def memory(given: Any, folder: Path, kept: Kept) -> dict[str, Any]:
    """Memory of a study of six joints."""
    place = folder / "memory"
    place.mkdir(exist_ok=True)
    return {"peak_gb": kept.of("peak_gb", lambda: peak_gb(place, given.quick))}


PARTS = {"arms": arms, "servo": servo, "faults": faults, "memory": memory}
QUICK_PARTS = ("arms", "servo")


def main() -> None:
    """Every part, printed and saved; figures are at the top."""
    options = parser(__doc__ or "", PARTS)
    options.add_argument("--arms", type=int, default=12, metavar="N", help="how many")
    options.add_argument("--workers", type=int, default=2, metavar="N", help="processes")
    options.add_argument("--resume", type=Path, metavar="FOLDER", help="keep results there; go on from them")
    given = options.parse_args()
    with tempfile.TemporaryDirectory(prefix="study-") as scratch:
        folder = given.resume or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        kept, table = Kept(folder / "results.jsonl"), {}
        for name in given.only or (QUICK_PARTS if given.quick else PARTS):
            table |= PARTS[name](given, folder, kept)
    if "servo_false_decided" in table and "false_decided" in table:
        table["false_decided"] += table["servo_false_decided"]
    show("Study", ["figure", "value"], [[k, v] for k, v in table.items() if isinstance(v, (int, float))])
    save(given.json, table)


if __name__ == "__main__":
    main()
