"""Exciting trajectories beside other tools and random motion, inside their limits, distinguishing models.

1. The UR10 of the package example-robot-data, 36 base columns, one 12 s period: condition number that
   exidyn, FIGAROH, random search and plain SLSQP reach, and when, with the same limits and time; what a
   short search of exidyn reaches beside a long one.
2. The paper's pair of runs on a KR270: deviations of drive gains, K_r and K_0, optimised against random.
3. Limits over random problems, checked by other means than the planner's.
4. Torque limits on arms drawn within the priors, and what a fit gains.
5. Probability of choosing the right one of two models, before and after a run that is made for it.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: one thread for every tool

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from common import options, save, show
from parts.excite import discriminate, first_motion, kr270, limits
from parts.excite.arm import Arm, ur10, why_no_arm
from parts.excite.ours import early, every_seed, gradient, ours
from parts.excite.peers import PeerResult, random_search, slsqp
from parts.excite.quick_start import short_and_long, sweep_check
from parts.figaroh import excitation as figaroh_excitation

BUDGET, QUICK_BUDGET = 40.0, 2.0
"""Seconds each tool has; FIGAROH takes 50 s for its hundred iterations and is near its end in 40."""


def against_peers(arm: Arm, budget: float, seeds: Sequence[int], collisions: bool) -> dict[str, Any]:
    """Condition number of every tool within the same time, and how long it took to reach it."""
    tools: dict[str, Callable[[int], PeerResult]] = {
        "exidyn": lambda seed: ours(arm, budget, seed, collisions=collisions),
        "random search": lambda seed: random_search(arm, budget, seed, collisions=collisions),
        "SLSQP, differences": lambda seed: slsqp(arm, budget, seed, collisions=collisions),
    }
    absent = figaroh_excitation.why_absent()
    if absent:
        print(absent)
    else:
        for name, own in (("FIGAROH", False), ("FIGAROH, this criterion", True)):
            settings = figaroh_excitation.FigarohSettings(collisions=collisions, unit_columns=own)
            tools[name] = partial(_figaroh, arm, budget, settings)
    found = {name: [tool(seed) for seed in seeds] for name, tool in tools.items()}
    rows = [_row(name, results) for name, results in found.items()]
    condition = "with self-collision" if collisions else "without self-collision"
    show(
        f"UR10, condition number of 36 base columns scaled to one; {budget:g} s a tool and seed, {condition}",
        ["tool", "best", "worst seed", "failed seeds", "first at s", "note of the best"],
        rows,
    )
    mine = found.pop("exidyn")
    suffix = "_with_collisions" if collisions else ""
    figures = {f"condition{suffix}": {row[0]: row[1] for row in rows}}
    for kind, peers in (("peer", found), ("tool", {n: r for n, r in found.items() if "FIGAROH" in n})):
        if peers:
            ratio, speedup = _compare(kind, mine, peers)
            figures |= {
                f"condition_over_best_{kind}{suffix}": ratio,
                f"speedup_over_best_{kind}{suffix}": speedup,
            }
    return figures


def _figaroh(arm: Arm, budget: float, settings: Any, seed: int) -> PeerResult:
    return figaroh_excitation.figaroh(arm, budget, seed, settings=settings)


def _compare(
    kind: str, mine: Sequence[PeerResult], peers: dict[str, Sequence[PeerResult]]
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
        f"  best {kind}: {name}, {peer.condition:.3g} after {took:.3g} s; exidyn is there after "
        f"{reached:.3g} s, {took / reached:.3g} times sooner, and ends at {ratio:.2g} of it"
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


def gradients(quick: bool, arm: Arm) -> dict[str, Any]:
    """Time of the exact gradient."""
    return gradient(arm)


def peers(quick: bool, arm: Arm) -> dict[str, Any]:
    """Every tool in the same time, without self-collision and with it."""
    if quick:
        return against_peers(arm, QUICK_BUDGET, [0], collisions=False)
    found = against_peers(arm, BUDGET, [0, 1], collisions=False)
    return found | against_peers(arm, BUDGET, [0], collisions=True)


def times(quick: bool, arm: Arm) -> dict[str, Any]:
    """A short search beside a long one."""
    return early(arm, *(([0], (0.5, 2.0)) if quick else ([0, 10, 20], (5.0, BUDGET))))


def quick_start(quick: bool, arm: Arm) -> dict[str, Any]:
    """What a short search delivers, and the check of sweeps."""
    found = short_and_long(arm, (1.0, 2.0), count=1) if quick else short_and_long(arm, (5.0, BUDGET))
    return found | sweep_check()


def seeds(quick: bool, arm: Arm) -> dict[str, Any]:
    """One start each."""
    return every_seed(arm, *((2, 1.0) if quick else (20, 8.0)))


ON_UR10 = {"gradient": gradients, "peers": peers, "early": times, "quick start": quick_start, "seeds": seeds}
OTHERS: dict[str, Callable[[bool], dict[str, Any]]] = {
    "kr270": kr270.run,
    "limits": lambda quick: limits.run(range(2 if quick else 200)),
    "first motion": first_motion.run,
    "discriminate": discriminate.run,
}


def main() -> None:
    chosen = options(__doc__.splitlines()[0], [*ON_UR10, *OTHERS])
    begun, figures = time.perf_counter(), dict[str, Any]()
    absent = why_no_arm()
    arm = None if absent else ur10()
    for name in chosen.only or [*ON_UR10, *OTHERS]:
        if name in OTHERS:
            figures |= OTHERS[name](chosen.quick)
        elif arm is not None:
            figures |= ON_UR10[name](chosen.quick, arm)
        else:
            print(f"{name}: {absent}")
    print(f"\n{time.perf_counter() - begun:.0f} s in all")
    save(chosen.json, figures)


if __name__ == "__main__":
    main()
