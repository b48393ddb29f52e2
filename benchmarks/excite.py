"""Exciting trajectories beside other tools and random motion, inside their limits.

1. Two arms of the package example-robot-data, one 12 s period, rigid base columns: condition number that
   exidyn, random search and plain SLSQP reach, and when, with the same limits and the same CPU time of one
   core.
2. The paper's pair of runs on a KR270: deviations of drive gains, K_r and K_0, optimized against random.
3. Limits over random problems, checked by other means than the planner's.

With `--json FILE` each case is kept in FILE.cases as soon as it is done, a run that was stopped goes on from
there, and FILE has the figures at the end; delete FILE.cases to measure anew. The first part needs the
package of the arms: pip install 'exidyn[bench]'.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: one thread for every tool

from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
from common import Kept, options, save, show
from parts.excite import kr270, limits
from parts.excite.arm import Arm, arm_of, why_no_arm
from parts.excite.peers import HARMONICS, PeerResult, ours, random_search, slsqp

from exidyn.trajectories.planning.wishes import Wishes

BUDGET, QUICK_BUDGET = 40.0, 2.0
"""CPU seconds that each tool has."""
ARMS = ("UR10", "xArm 7")
SEARCHES = {"exidyn": ours, "random search": random_search, "SLSQP, differences": slsqp}
OURS = (Wishes().harmonics, 16)
"""Harmonics of our own search: as many as it takes unless asked otherwise, and more."""


def against_peers(arm: Arm, quick: bool, kept: Kept) -> dict[str, Any]:
    """Condition number of every tool within the same time, and how long it took to reach it."""
    budget = QUICK_BUDGET if quick else BUDGET
    tools: dict[str, Callable[[], PeerResult]] = {
        f"{name}, {many} harmonics": partial(search, arm, budget, 0, many)
        for name, search in SEARCHES.items()
        for many in (OURS if search is ours else HARMONICS)[: 1 if quick else None]
    }
    found = {
        name: PeerResult(**kept.of(f"{arm.name}, {name}, {budget:g} s", lambda tool=tool: asdict(tool())))
        for name, tool in tools.items()
    }
    show(
        f"{arm.name}, condition number of {len(arm.base.kept)} scaled base columns; {budget:g} CPU s a tool",
        ["tool", "condition", "first at CPU s", "note of the best"],
        [[name, one.condition, time_to(one.history, one.condition), one.note] for name, one in found.items()],
    )
    figures: dict[str, Any] = {"condition": {name: one.condition for name, one in found.items()}}
    mine = {name: found.pop(name) for name in list(found) if name.startswith("exidyn")}
    for name, result in mine.items():
        more = "" if name == f"exidyn, {OURS[0]} harmonics" else name.removeprefix("exidyn")
        ratio, speedup = compare(name, result, found)
        figures |= {f"condition_over_best_peer{more}": ratio, f"speedup_to_peer{more}": speedup}
    return figures


def compare(own: str, mine: PeerResult, peers: dict[str, PeerResult]) -> tuple[float, float]:
    """Our condition number over the best one of the others, and how much sooner we are at theirs."""
    name, peer = min(peers.items(), key=lambda each: each[1].condition)
    if not np.isfinite(peer.condition):
        print("  no peer found a motion within the limits")
        return 0.0, np.inf
    took, reached = time_to(peer.history, peer.condition), time_to(mine.history, peer.condition)
    ratio = mine.condition / peer.condition
    print(
        f"  best peer: {name}, {peer.condition:.3g} after {took:.3g} CPU s; {own} is there after "
        f"{reached:.3g} CPU s, {took / reached:.3g} times sooner, and ends at {ratio:.2g} of it"
    )
    return ratio, took / reached


def time_to(history: Sequence[tuple[float, float]], level: float) -> float:
    """Seconds until a search first held something at least as good; infinite if never."""
    return next((seconds for seconds, reached in history if reached <= level * (1 + 1e-9)), np.inf)


def peers(quick: bool, kept: Kept) -> dict[str, Any]:
    """Every tool in the same time on both arms."""
    if absent := why_no_arm():
        print(f"peers: {absent}")
        return {}
    found = {name: against_peers(arm_of(name), quick, kept) for name in ARMS[: 1 if quick else None]}
    keys = ("condition_over_best_peer", f"condition_over_best_peer, {OURS[1]} harmonics")
    figures = {
        key: max(one[key] for one in found.values())
        for key in keys
        if all(key in one for one in found.values())
    }
    return figures | {"tools": found}


PARTS: dict[str, Callable[[bool, Kept], dict[str, Any]]] = {
    "peers": peers,
    "kr270": lambda quick, kept: kept.of("kr270", lambda: kr270.run(quick)),
    "limits": lambda quick, kept: limits.run(range(2 if quick else 200), kept),
}


def main() -> None:
    chosen = options(__doc__.splitlines()[0], list(PARTS))
    ending = ".quick.cases" if chosen.quick else ".cases"
    kept = Kept(chosen.json.with_name(f"{chosen.json.name}{ending}") if chosen.json else None)
    figures: dict[str, Any] = {}
    for name in chosen.only or PARTS:
        figures |= PARTS[name](chosen.quick, kept)
    save(chosen.json, figures)


if __name__ == "__main__":
    main()
