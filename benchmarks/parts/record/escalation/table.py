"""Stops that do not work: every fault in every stage of a run, and what is asked of the driver then."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from common import show

from exidyn.drivers import StopLevel

from .arm import heavy, light
from .cases import CASES, RESTS, WITHIN, Case
from .run import Ran, ran

LETTERS = {StopLevel.BRAKE: "B", StopLevel.QUICK: "Q", StopLevel.OFF: "O"}


def wrong(case: Case, seen: Ran) -> list[str]:
    """What is not as it must be, a sentence each."""
    found = []
    levels = "".join(LETTERS[stop.level] for stop in seen.stops)
    if levels != case.levels:
        found.append(f"asked {levels or 'nothing'}, not {case.levels or 'nothing'}")
    asked = [level for level in (stop.level for stop in seen.stops) if level > StopLevel.BRAKE]
    if seen.asked != asked or sorted(set(seen.asked)) != seen.asked:
        found.append(f"the driver was asked {seen.asked}, the recording has {asked}")
    found += [
        f"{stop.level.name} after {stop.waited:.2f} s, limit {WITHIN[stop.level]} s"
        for stop in seen.stops
        if stop.waited > WITHIN[stop.level] + case.fault.late
    ]
    if seen.cycles != seen.recorded:
        found.append(f"{seen.cycles - seen.recorded} cycles are not recorded")
    if case.fault.rests and seen.speed > RESTS:
        found.append(f"still {seen.speed:.2f} rad/s in the end")
    return found


def main(quick: bool) -> dict[str, Any]:
    rows, failed = list[Sequence[Any]](), []
    for case in CASES:
        if quick and not case.quick:
            continue
        seen = ran(case, light if quick else heavy)
        bad = wrong(case, seen)
        failed += [f"{case.fault.name}, {case.stage}"] * bool(bad)
        times = {stop.level: stop.waited for stop in seen.stops}
        rows.append(
            [
                case.fault.name,
                case.stage,
                " ".join(stop.level.name for stop in seen.stops) or "nothing",
                times.get(StopLevel.QUICK),
                times.get(StopLevel.OFF),
                np.degrees(seen.way),
                "NO: " + "; ".join(bad) if bad else "ok",
            ]
        )
    show(
        "Stops that do not work, on the mock off the wall clock",
        ["fault of joint1", "begins while", "asked", "QUICK after s", "OFF after s", "way deg", ""],
        rows,
    )
    print("  after     the fault, or the level before if that was asked for later")
    print("  way       of joint1 from the fault until the end")
    return {
        "escalations": len(rows),
        "escalations_failed": len(failed),
        "escalations_failed_names": failed,
        "escalation_quick_longest": max((row[3] for row in rows if row[3] is not None), default=None),
        "escalation_off_longest": max((row[4] for row in rows if row[4] is not None), default=None),
    }
