"""Payload: how well mass, center and inertia are identified, and whether intervals hold the truth."""

import os
from functools import partial
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


def main() -> None:
    """Run and print."""
    options = parser(__doc__ or "")
    options.add_argument("--resume", type=Path, metavar="FOLDER", help="keep results there, and go on")
    given = options.parse_args()
    if given.resume:
        given.resume.mkdir(parents=True, exist_ok=True)
    kept = Kept(given.resume / f"payload{'-quick' * given.quick}.jsonl" if given.resume else None)
    wanted = cases(given.quick)
    scores = [kept.of(case.name, partial(of_case, case)) for case in wanted]
    makers = real_cases(given.quick) | ({} if given.quick else example_cases())
    real = {name: kept.of(name, make) for name, make in makers.items()}
    links = by_links(wanted, scores)
    show("simulated payloads, by the errors of the links", BY_LINKS, links)
    stated = [(case, score) for case, score in zip(wanted, scores, strict=True) if case.links == 1.0]
    tables(stated, real)
    figures = summary([score for _, score in stated])
    figures["by_links"] = [dict(zip(BY_LINKS, row, strict=True)) for row in links]
    save(given.json, figures | {"real": real})


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


def summary(scores: list[dict[str, Any]]) -> dict[str, Any]:
    """Figures over all simulated arms with links drawn to their tolerance."""
    return {
        "mass_error_percent_by_way": {
            way: float(np.median([abs(s[way]["error_percent"]) for s in scores])) for way in WAYS
        },
        "interval_percent_by_way": {
            way: float(np.median([s[way]["half_percent"] for s in scores])) for way in WAYS
        },
        "coverage_by_way": {
            way: {what: share(scores, way, what) for what in ("mass", "center", "inertia")} for way in WAYS
        },
        "check_passed_percent": 100.0 * float(np.mean([s[way]["check"] for s in scores for way in WAYS])),
        "motion_seconds": float(np.median([s[FIT]["seconds"] for s in scores])),
        "cases": len(scores),
    }


def tables(stated: list[tuple[Case, dict[str, Any]]], real: dict[str, Any]) -> None:
    """Print one row for each arm and way, and one for each real payload and that of the example."""
    rows = []
    for arm in dict.fromkeys(case.arm.name for case, _ in stated):
        own = [score for case, score in stated if case.arm.name == arm]
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
