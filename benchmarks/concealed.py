"""Concealed cases: arms with something wrong, recorded; is it found, and named?

The plant shares no formulas with what is under test, which sees the folders of the cases and never their
truths: only the scorer reads those.
"""

import argparse
import json
import os
import tempfile
import time
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import ExitStack
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: one thread a process, and two processes

from common import save
from parts.concealed.answerers import ANSWERERS, Answerer
from parts.concealed.case import concealed_set, make, quick_set, warm_up
from parts.concealed.scoring import Pair, pairs, print_scores, read_answer, read_truths
from tqdm import tqdm

PROCESSES = 2


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="four small cases, under a minute")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures to FILE")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="cases, truth and answers stay in FOLDER")
    parser.add_argument(
        "--bare", action="store_true", help="answer every case a second time, without the values it states"
    )
    parser.add_argument("--seed", type=int, default=1, help="another set of cases")
    parser.add_argument("--only", nargs="+", metavar="EFFECT", help="only cases of these effects")
    parser.add_argument(
        "--resume", action="store_true", help="with --keep: make and answer only cases that are not answered"
    )
    parser.add_argument("--made", action="store_true", help="answer the cases that FOLDER already has")
    return parser.parse_args()


def timed(folder: Path, answer: Answerer) -> dict[str, Any]:
    """An answer, with the seconds it took; an error is an answer too."""
    began = time.perf_counter()
    try:
        given = answer(folder)
    except Exception as error:  # the other cases are worth their score
        given = {"findings": [], "unexplained": False, "error": f"{type(error).__name__}: {error}"}
    return given | {"seconds": time.perf_counter() - began}


def before(folder: Path, file: str, resume: bool) -> dict[str, Any]:
    """Answers of an earlier run, by case; none without `resume`."""
    there = resume and (folder / file).exists()
    return dict(json.loads((folder / file).read_text())) if there else {}


def answered(
    who: str, file: str, folder: Path, pool: Executor, only: set[str] | None, resume: bool
) -> list[Pair]:
    """All cases of a folder with the answers of `who`, written to a file beside them as they come."""
    given = before(folder, file, resume)
    asked = [place for place in (folder / "cases").iterdir() if only is None or place.name in only]
    places = sorted(place for place in asked if place.name not in given)
    answer = partial(timed, answer=ANSWERERS[who])
    for place, one in zip(
        places, tqdm(pool.map(answer, places), total=len(places), unit="case"), strict=True
    ):
        given[place.name] = one
        (folder / file).write_text(json.dumps(given, indent=1) + "\n")
        if "error" in one:
            print(f"{place.name}: {one['error']}")
    return pairs(read_truths(folder / "truth"), {name: read_answer(case) for name, case in given.items()})


def main(options: argparse.Namespace) -> dict[str, Any]:
    """Make, answer and score; gives the figures."""
    with ExitStack() as stack:
        folder = options.keep or Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="concealed-")))
        pool = stack.enter_context(ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn")))
        cases = quick_set(options.seed) if options.quick else concealed_set(options.seed)
        cases = [case for case in cases if not options.only or set(case.effects) & set(options.only)]
        if not options.made:
            warm_up()
            done = before(folder, "answers.json", options.resume)
            missing = [case for case in cases if case.name not in done]
            list(pool.map(partial(make, cases=folder / "cases", truths=folder / "truth"), missing))
        only = None if options.made else {case.name for case in cases}
        files = {"product": "answers.json"} | ({"bare": "answers-bare.json"} if options.bare else {})
        return print_scores(
            {who: answered(who, file, folder, pool, only, options.resume) for who, file in files.items()}
        )


if __name__ == "__main__":
    chosen = arguments()
    save(chosen.json, main(chosen))
