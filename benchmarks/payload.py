"""Payload: how well mass, center and inertia are identified, and whether intervals hold the truth."""

import os
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy

import numpy as np
from common import Kept, parser, save, show
from parts.payload.real import example_cases, real_cases
from parts.payload.simulated import ARMS, FIT, WAYS, Case, of_case

SEEDS = 12
"""Arms drawn for each payload."""
BY_LINKS = ["links", "arm known from", "cases", "mass held %", "error / interval", "bias / interval"]
LINKS = (1.0, 0.3, 2.0)
"""Errors of the links over their stated tolerance."""
PROCESSES = 1


def cases(quick: bool) -> list[Case]:
    """Payloads on drawn arms; one payload of each arm in a quick run."""
    there = [arm for arm in ARMS if arm.there]
    return [
        Case(arm, mass, seed, links)
        for links in LINKS
        for seed in range(1 if quick else SEEDS)  # so that a part of the cases has every arm
        for arm in there
        for mass in (arm.masses[-1:] if quick else arm.masses)
    ]


def simulated(kept: Kept, wanted: list[Case]) -> list[dict[str, Any]]:
    """Scores of all cases; those that are kept are not made again."""
    new = [case for case in wanted if case.name not in kept.found]
    with ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn")) as pool:
        for case, scores in zip(new, pool.map(of_case, new), strict=True):
            kept.put(case.name, scores)
    return [kept.found[case.name] for case in wanted]


def main() -> None:
    """Run and print."""
    options = parser(__doc__ or "")
    options.add_argument("--resume", type=Path, metavar="FOLDER", help="keep results there, and go on")
    given = options.parse_args()
    if given.resume:
        given.resume.mkdir(parents=True, exist_ok=True)
    kept = Kept(given.resume / f"payload{'-quick' * given.quick}.jsonl" if given.resume else None)
    wanted = cases(given.quick)
    scores = simulated(kept, wanted)
    makers = real_cases(given.quick) | ({} if given.quick else example_cases())
    real = {name: kept.of(name, make) for name, make in makers.items()}
    figures = summary(wanted, scores) | {"real": real}
    tables(wanted, scores, real)
    save(given.json, figures)


def as_stated(wanted: list[Case], scores: list[dict[str, Any]]) -> tuple[list[Case], list[dict[str, Any]]]:
    """Cases, and scores, of links drawn to their tolerance."""
    pairs = [pair for pair in zip(wanted, scores, strict=True) if pair[0].links == 1.0]
    return [case for case, _ in pairs], [score for _, score in pairs]


def by_links(wanted: list[Case], scores: list[dict[str, Any]]) -> list[list[Any]]:
    """For links drawn to each multiple of their tolerance: mass held, error and bias over the interval."""
    rows = []
    for links in LINKS:
        drawn = [score for case, score in zip(wanted, scores, strict=True) if case.links == links]
        for way in WAYS[1:]:
            over = [score[way]["error_percent"] / score[way]["half_percent"] for score in drawn]
            rows.append([links, way, len(drawn), share(drawn, way, "mass"), np.std(over), np.mean(over)])
    return rows


def share(scores: list[dict[str, Any]], way: str, what: str) -> float:
    """Share of intervals that hold the truth [%]."""
    return 100.0 * float(np.mean(np.concatenate([score[way][what] for score in scores])))


def summary(wanted: list[Case], scores: list[dict[str, Any]]) -> dict[str, Any]:
    """Figures over all simulated arms, with links drawn to their tolerance unless stated."""
    links = by_links(wanted, scores)
    wanted, scores = as_stated(wanted, scores)
    errors = {way: float(np.median([abs(s[way]["error_percent"]) for s in scores])) for way in WAYS}
    coverage = {
        way: {what: share(scores, way, what) for what in ("mass", "center", "inertia")} for way in WAYS
    }
    return {
        "mass_error_percent": errors[FIT],
        "mass_error_percent_by_way": errors,
        "interval_percent_by_way": {
            way: float(np.median([s[way]["half_percent"] for s in scores])) for way in WAYS
        },
        "coverage": coverage[FIT],
        "coverage_by_way": coverage,
        "check_passed_percent": 100.0 * float(np.mean([s[way]["check"] for s in scores for way in WAYS])),
        "motion_seconds": float(np.median([s[FIT]["seconds"] for s in scores])),
        "cases": len(wanted),
        "by_links": [dict(zip(BY_LINKS, row, strict=True)) for row in links],
    }


def tables(wanted: list[Case], scores: list[dict[str, Any]], real: dict[str, Any]) -> None:
    """Print one row for each arm and way, and one for each real payload and that of the example."""
    show("simulated payloads, by the errors of the links", BY_LINKS, by_links(wanted, scores))
    wanted, scores = as_stated(wanted, scores)
    rows = []
    for arm in dict.fromkeys(case.arm.name for case in wanted):
        own = [score for case, score in zip(wanted, scores, strict=True) if case.arm.name == arm]
        for way in WAYS:
            error = np.median([abs(score[way]["error_percent"]) for score in own])
            half = np.median([score[way]["half_percent"] for score in own])
            center = np.median([score[way]["center_error_mm"] for score in own])
            held = [share(own, way, what) for what in ("mass", "center", "inertia")]
            rows.append([arm, way, len(own), error, half, center, *held])
    head = ["arm", "arm known from", "cases", "mass error %", "interval ± %", "center error mm"]
    show("simulated payloads, medians", [*head, "mass held %", "center held %", "inertia held %"], rows)
    listed = [
        [name, one["true"], one["found"], one["low"], one["high"], one["error_percent"], str(one["holds"])]
        for name, one in real.items()
    ]
    show(
        "real payloads, and that of exidyn example",
        ["", "true [kg]", "found", "low", "high", "error %", "held"],
        listed,
    )


if __name__ == "__main__":
    main()
