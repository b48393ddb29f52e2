"""Exciting trajectories beside other tools and random motion, inside their limits, distinguishing models.

1. Two arms of the package example-robot-data, one 12 s period, rigid base columns: condition number that
   exidyn, FIGAROH, random search and plain SLSQP reach, and when, with the same limits and the same CPU time
   of one core.
2. What a short search delivers beside a long one, on five arms; the check of sweeps.
3. The paper's pair of runs on a KR270: deviations of drive gains, K_r and K_0, optimised against random.
4. Limits over random problems, checked by other means than the planner's.
5. Torque limits on arms drawn within the priors, and what a fit gains.
6. The condition number that a plan file of a pair states, beside that of its motion, computed anew.
7. Probability of choosing the right one of two models, before and after a run that is made for it.

With `--json FILE` each case is kept in FILE.cases as soon as it is done, a run that was stopped goes on from
there, and FILE has the figures at the end; delete FILE.cases to measure anew. It needs FIGAROH, its solver
and the package of the arms: pip install 'exidyn[bench]'.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: one thread for every tool

import time
from argparse import Namespace
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from common import Kept, options, save, show
from parts.excite import discriminate, first_motion, kr270, limits, printed
from parts.excite.arm import Arm, arm_of, why_no_arm
from parts.excite.ours import every_seed, gradient, ours
from parts.excite.peers import HARMONICS, PeerResult, random_search, slsqp
from parts.excite.quick_start import short_and_long, sweep_check
from parts.figaroh import excitation as figaroh_excitation
from parts.figaroh.trajectory import FigarohSettings

from exidyn.trajectories.planning.wishes import Wishes

BUDGET, QUICK_BUDGET = 40.0, 2.0
"""CPU seconds each tool has; FIGAROH takes 50 s for its hundred iterations and is near its end in 40."""
SEEDS, QUICK_SEEDS = {"UR10": [0], "xArm 7": [0]}, {"UR10": [0]}
"""Seeds by arm."""
OURS = (Wishes().harmonics, 16)
"""Harmonics of our own search: as many as it takes unless asked otherwise, and more."""
FIGAROH = (
    FigarohSettings(unit_columns=True),
    FigarohSettings(unit_columns=True, way_points=13),
    FigarohSettings(),
)
"""With the criterion that is judged, with more freedom, and as shipped; a quick run has the first."""
CPU = time.process_time
"""Clock of all tools."""


def against_peers(
    arm: Arm, budget: float, seeds: Sequence[int], collisions: bool, kept: Kept
) -> dict[str, Any]:
    """Condition number of every tool within the same time, and how long it took to reach it."""
    quick = budget <= QUICK_BUDGET
    searches = {"exidyn": ours, "random search": random_search, "SLSQP, differences": slsqp}
    tools: dict[str, Callable[[int], PeerResult]] = {
        f"{name}, {many} harmonics": partial(_search, search, arm, budget, many, collisions)
        for name, search in searches.items()
        for many in (OURS if search is ours else HARMONICS)[: 1 if quick else None]
    }
    absent = figaroh_excitation.why_absent()
    if absent:
        print(absent)
    else:
        for settings in FIGAROH[: 1 if quick else None]:
            settings = settings._replace(collisions=collisions)
            tools[settings.name] = partial(_figaroh, arm, budget, settings)
    how = "with self-collision" if collisions else "without self-collision"
    found = {name: [_kept(kept, arm, name, how, tool, s) for s in seeds] for name, tool in tools.items()}
    show(
        f"{arm.name}, condition number of {len(arm.base.kept)} base columns scaled to one; {budget:g} CPU s a"
        f" tool and seed, {how}",
        ["tool", "best", "worst seed", "failed seeds", "first at CPU s", "note of the best"],
        [_row(name, results) for name, results in found.items()],
    )
    figures: dict[str, Any] = {
        "condition": {name: min(r.condition for r in each) for name, each in found.items()}
    }
    mine = {name: found.pop(name) for name in list(found) if name.startswith("exidyn")}
    for kind, peers in (("peer", found), ("figaroh", {n: r for n, r in found.items() if "FIGAROH" in n})):
        for name, results in mine.items() if peers else ():
            more = "" if name == f"exidyn, {OURS[0]} harmonics" else name.removeprefix("exidyn")
            ratio, speedup = _compare(kind, name, results, peers)
            figures |= {f"condition_over_best_{kind}{more}": ratio, f"speedup_to_{kind}{more}": speedup}
    return figures


def _kept(
    kept: Kept, arm: Arm, name: str, how: str, tool: Callable[[int], PeerResult], seed: int
) -> PeerResult:
    found = kept.of(f"{arm.name}, {name}, {how}, seed {seed}", lambda: asdict(tool(seed)))
    return PeerResult(**found)


def _search(
    search: Callable[..., PeerResult], arm: Arm, budget: float, harmonics: int, collisions: bool, seed: int
) -> PeerResult:
    return search(arm, budget, seed, harmonics, collisions=collisions, clock=CPU)


def _figaroh(arm: Arm, budget: float, settings: Any, seed: int) -> PeerResult:
    return figaroh_excitation.figaroh(arm, budget, seed, settings=settings, clock=CPU)


def _compare(
    kind: str, own: str, mine: Sequence[PeerResult], peers: dict[str, Sequence[PeerResult]]
) -> tuple[float, float]:
    """Our condition number over the best one of the others, and how much sooner we are at theirs."""
    name, peer = min(
        ((name, one) for name, results in peers.items() for one in results),
        key=lambda each: each[1].condition,
    )
    if not np.isfinite(peer.condition):
        print(f"  no {kind} found a motion within the limits")
        return 0.0, np.inf
    took = _when(peer.history, peer.condition)
    reached = float(np.median([_when(one.history, peer.condition) for one in mine]))
    ratio = min(one.condition for one in mine) / peer.condition
    print(
        f"  best {kind}: {name}, {peer.condition:.3g} after {took:.3g} CPU s; {own} is there after "
        f"{reached:.3g} CPU s, {took / reached:.3g} times sooner, and ends at {ratio:.2g} of it"
    )
    return ratio, took / reached


def _row(name: str, results: Sequence[PeerResult]) -> list[Any]:
    best = min(results, key=lambda one: one.condition)
    kept = [one.condition for one in results if np.isfinite(one.condition)]
    when = _when(best.history, best.condition)
    return [name, best.condition, max(kept, default=np.inf), len(results) - len(kept), when, best.note]


def _when(history: Sequence[tuple[float, float]], level: float) -> float:
    """Seconds until a search first held something at least as good; infinite if never."""
    return next((seconds for seconds, reached in history if reached <= level * (1 + 1e-9)), np.inf)


def peers(quick: bool, kept: Kept) -> dict[str, Any]:
    """Every tool in the same time on both arms, without self-collision, and on the first with it too."""
    budget, seeds = (QUICK_BUDGET, QUICK_SEEDS) if quick else (BUDGET, SEEDS)
    found = {name: against_peers(arm_of(name), budget, some, False, kept) for name, some in seeds.items()}
    figures = {
        key: worst(one[key] for one in found.values())
        for key, worst in (
            ("condition_over_best_peer", max),
            (f"condition_over_best_peer, {OURS[1]} harmonics", max),
            ("speedup_to_figaroh", min),
        )
        if all(key in one for one in found.values())
    }
    if not quick:
        found["UR10, clear of itself"] = against_peers(arm_of("UR10"), budget, [0], True, kept)
    return figures | {"tools": found}


def quick_start(quick: bool, kept: Kept) -> dict[str, Any]:
    """What a short search delivers, and the check of sweeps."""
    seconds, names = ((1.0, 2.0), ("UR10",)) if quick else ((5.0, BUDGET), ())
    return short_and_long(seconds, kept, names) | kept.of("sweep check", sweep_check)


def whole(name: str, work: Callable[[bool], dict[str, Any]]) -> Callable[[bool, Kept], dict[str, Any]]:
    """A part that is one case."""
    return lambda quick, kept: kept.of(name, lambda: work(quick))


PARTS: dict[str, Callable[[bool, Kept], dict[str, Any]]] = {
    "gradient": whole("gradient", lambda quick: gradient(arm_of("UR10"))),
    "peers": peers,
    "quick start": quick_start,
    "seeds": whole("seeds", lambda quick: every_seed(arm_of("UR10"), *((2, 1.0) if quick else (20, 8.0)))),
    "kr270": whole("kr270", kr270.run),
    "limits": lambda quick, kept: limits.run(range(2 if quick else 200), kept),
    "printed": printed.run,
    "first motion": whole("first motion", first_motion.run),
    "discriminate": whole("discriminate", discriminate.run),
}
NOT_QUICK = ("seeds", "discriminate", "printed")
"""Parts that a quick run has only when asked: two starts say little, pairs of models take 12 s, and plans of
pairs half a minute."""
OF_PACKAGE = ("gradient", "peers", "quick start", "seeds")
"""Parts that need the arms of the package."""


def main() -> None:
    chosen = options(__doc__.splitlines()[0], list(PARTS))
    begun, figures, kept = time.perf_counter(), dict[str, Any](), Kept(_cases(chosen))
    absent = why_no_arm()
    every = [name for name in PARTS if not (chosen.quick and name in NOT_QUICK)]
    for name in chosen.only or every:
        if absent and name in OF_PACKAGE:
            print(f"{name}: {absent}")
            continue
        figures |= PARTS[name](chosen.quick, kept)
    print(f"\n{time.perf_counter() - begun:.0f} s in all, at a load of {os.getloadavg()[0]:.1f}")
    save(chosen.json, figures)


def _cases(chosen: Namespace) -> Path | None:
    """Where the cases of a run are kept; those of a quick one apart."""
    if chosen.json is None:
        return None
    file: Path = chosen.json
    return file.with_name(f"{file.name}.{'quick.' if chosen.quick else ''}cases")


if __name__ == "__main__":
    main()
