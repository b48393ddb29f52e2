"""Study: arms with something concealed; is it found, and in how much motion beside a fixed programme?"""

import json
import os
import tempfile
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy

import numpy as np
from common import parser, save, show
from parts.study.cases import MINUTES as STUDY
from parts.study.cases import QUICK as QUICK_STUDY
from parts.study.cases import Result, drawn, studied
from parts.study.kscale import MINUTES, asked_for
from parts.study.kscale import QUICK as QUICK_MINUTES

QUICK, ALL = 1, 30
"""Arms: two, one and no effects in turn."""


def figures(results: list[Result]) -> dict[str, Any]:
    """What is measured; motion over that of the fixed programme where both found what is there."""
    both = [one for one in results if one.found == one.fixed == one.concealed]
    proposed = [settled for one in results for settled in one.proposed]
    return {
        "arms": len(results),
        "right": sum(one.found == one.concealed for one in results) / len(results),
        "false": sum(len(one.found - one.concealed) for one in results),
        "fixed_right": sum(one.fixed == one.concealed for one in results) / len(results),
        "fixed_false": sum(len(one.fixed - one.concealed) for one in results),
        "motion_minutes": float(np.mean([one.minutes for one in results])),
        "motion_minutes_over_fixed": float(np.mean([one.minutes / one.fixed_minutes for one in both]))
        if both
        else None,
        "compared": len(both),
        "settled_by_proposed_run": sum(proposed) / len(proposed) if proposed else None,
        "proposed_runs": len(proposed),
    }


def mocks(given: Any) -> dict[str, Any]:
    """Every simulated arm; those whose lines are there are not made again."""
    made = dict(_kept(given.lines)) if given.lines and given.lines.exists() else {}
    numbers = range(given.first, given.first + (given.arms or (QUICK if given.quick else ALL)))
    for number in numbers:
        if number in made:
            continue
        with tempfile.TemporaryDirectory(prefix="study-") as folder:
            minutes = QUICK_STUDY if given.quick else STUDY
            made[number] = studied(drawn(number, 2 - number % 3), number, Path(folder), minutes)
        print(f"arm {number}: {made[number]}", flush=True)
        if given.lines:
            with given.lines.open("a") as file:
                file.write(json.dumps({"arm": number} | asdict(made[number]), default=sorted) + "\n")
    return figures([made[number] for number in numbers])


def _kept(lines: Path) -> Iterator[tuple[int, Result]]:
    """Arms of a file, a line each."""
    for line in map(json.loads, lines.read_text().splitlines()):
        yield line.pop("arm"), Result.read(line)


def servo(given: Any) -> dict[str, Any]:
    """Recordings of one mass, then of all."""
    with tempfile.TemporaryDirectory(prefix="study-") as folder:
        found = asked_for(Path(folder), QUICK_MINUTES if given.quick else MINUTES)
    print(found, flush=True)
    return found


PARTS = {"mocks": mocks, "kscale": servo}


def main() -> None:
    """Study every arm, print and save."""
    options = parser(__doc__ or "", PARTS)
    options.add_argument("--first", type=int, default=0, metavar="N", help="number of the first mock")
    options.add_argument("--arms", type=int, metavar="N", help="how many")
    options.add_argument("--lines", type=Path, metavar="FILE", help="result of each arm; go on from it")
    given = options.parse_args()
    table = {name: PARTS[name](given) for name in given.only or PARTS}
    if "mocks" in table:
        rows = [[name, value] for name, value in table["mocks"].items()]
        show("Study beside the fixed programme", ["figure", "value"], rows)
    save(given.json, table)


if __name__ == "__main__":
    main()
