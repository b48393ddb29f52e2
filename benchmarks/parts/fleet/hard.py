"""Hard fleets: one cause put into some arms, and all that was said of every arm."""

import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from exidyn.identification.fleet.drift import ArmDrift
from exidyn.identification.fleet.learned import learned
from exidyn.identification.fleet.report import KindReport, change_words, odd_words
from exidyn.identification.fleet.runs import Frame

from .arms import Wear
from .recordings import START, WEEK
from .seasons import check_run
from .tables import EVENTS, Event, season

DECADE = 3652.5 / WEEK
"""Weeks of ten years."""
RATE = 0.1
"""False alarms an arm and year that are allowed: one in ten years."""
NO_CHANGE = ("outlier", "stray")
"""What happens to a single run."""


@dataclass(frozen=True)
class Said:
    """What was said of one arm.

    Attributes:
        arm: Its name.
        cause: What was put in; empty for nothing.
        creeps: Whether that is creep.
        right: Whether it was said, and named as what it is.
        statements: Changes and runs out of line that were said of it.
        false: Alarms but for one after the change, if there was one.
        weeks: From the change to its alarm; None where there was no change, or no alarm.
        early: Changes that are said to be first seen before they were there.
        words: All that was said.
    """

    arm: str
    cause: str
    creeps: bool
    right: bool
    statements: int
    false: int
    weeks: float | None
    early: int
    words: list[str]


@dataclass(frozen=True)
class Fleet:
    """One fleet: what was said of its arms, CPU time [s] of that, weeks, whether the bound was printed."""

    said: list[Said]
    seconds: float
    weeks: int
    bounded: bool


def asked(kind: str, seed: int, arms: int, weeks: int, begin: int | None) -> Fleet:
    """A fleet of arms whose seeds begin with one; the first ten have a cause each, unless none begins."""
    put_in = EVENTS[kind][:arms] if begin is not None else ()
    events = {n: Event(what, (begin or 0) + n % 3) for n, what in enumerate(put_in)}
    runs = {
        f"{kind}-{n + 1:02}": season(
            kind, f"{kind}-{n + 1:02}", seed + n, weeks, events.get(n), seed + (n + 7) % arms
        )
        for n in range(arms)
    }
    start = time.process_time()
    frame = Frame.of(check_run(kind, False).kind, [run for own in runs.values() for run in own])
    report = KindReport.of(kind, learned(frame, runs), RATE)
    seconds = time.process_time() - start
    said = [_said(report, name, events.get(n)) for n, name in enumerate(runs)]
    return Fleet(said, seconds, weeks, report.scatter.holds)


def _said(report: KindReport, arm: str, event: Event | None) -> Said:
    own, learned_ = report.drifts[arm], report.learned
    words = [change_words(learned_, one) for one in own.changes] + [
        odd_words(learned_, one) for one in own.odd
    ]
    changes = event is not None and event.what not in NO_CHANGE
    day = START + WEEK * event.week if event else np.inf
    after = [one for one in own.alarms if one >= day] if changes else []
    return Said(
        arm=arm,
        cause="" if event is None else event.what if isinstance(event.what, str) else event.what.effect,
        creeps=event is not None and isinstance(event.what, Wear) and event.what.weeks > 0.0,
        right=event is not None and _right(report, own, event),
        statements=len(words),
        false=len(own.alarms) - min(len(after), 1),
        weeks=float((after[0] - day) / WEEK) if after else None,
        early=sum(one.alarmed < day for one in own.changes) if changes else 0,
        words=words,
    )


def _right(report: KindReport, own: ArmDrift, event: Event) -> bool:
    """Whether the surest statement names what was put in."""
    if event.what in NO_CHANGE:
        odd = [one for one in own.odd if abs(one.day - START - WEEK * event.week) < WEEK]
        stray = event.what == "stray"
        return not own.changes and any(
            one.suspect.name == "exchange" and bool(one.like) == stray for one in odd
        )
    if not own.changes:
        return False
    best = max(own.changes, key=lambda one: one.evidence)
    if isinstance(event.what, str):
        return best.suspect.name == event.what
    cause = report.learned.frame.causes[best.suspect.causes[best.surest]] if best.suspect.causes else None
    return not best.suspect.name and cause is not None and (cause.effect, cause.joint + 1) == event.what[:2]


def alarm_figures(fleets: Sequence[Fleet]) -> dict[str, Any]:
    """False alarms of all arms together, and the rate above which as few would be seen with 5 %."""
    every = [(one.false, fleet.weeks) for fleet in fleets for one in fleet.said]
    decades, false = sum(weeks for _, weeks in every) / DECADE, sum(one for one, _ in every)
    return {
        "arms": len(every),
        "arm_decades": decades,
        "false_alarms": false,
        "false_alarms_per_arm_decade": false / decades,
        "false_alarms_per_arm_decade_at_most_95": float(stats.chi2.isf(0.05, 2 * (false + 1)))
        / 2.0
        / decades,
    }


def hard_figures(fleets: Sequence[Fleet], begin: int) -> dict[str, Any]:
    """Of all of them together; a creep that was not found counts as the weeks that there were."""
    every = [(one, fleet.weeks) for fleet in fleets for one in fleet.said]
    caused = [one for one, _ in every if one.cause]
    creeps = [
        one.weeks if one.weeks is not None else float(weeks - begin) for one, weeks in every if one.creeps
    ]
    told = [one.statements for one in caused if one.statements]
    runs = sum(weeks for _, weeks in every)
    return alarm_figures(fleets) | {
        "fleets_of_which_a_bound_was_printed": sum(one.bounded for one in fleets) / len(fleets),
        "causes": len(caused),
        "causes_said": len(told),
        "causes_named_right": sum(one.right for one in caused),
        "changes_per_cause": sum(told) / len(told) if told else None,
        "statements_of_sound_arms": sum(one.statements for one, _ in every if not one.cause),
        "weeks_to_find_creep": float(np.mean(creeps)) if creeps else None,
        "weeks_to_find_creep_most": max(creeps, default=None),
        "weeks_to_find_others": max(
            (one.weeks for one in caused if one.weeks and not one.creeps), default=None
        ),
        "first_seen_before_the_change": sum(one.early for one in caused),
        "analysis_runs_per_cpu_minute": 60.0 * runs / sum(one.seconds for one in fleets),
    }


def kept(path: Path | None, key: str, ask: Any) -> Fleet:
    """A fleet as an earlier call has kept it, or asked now and kept."""
    table = json.loads(path.read_text()) if path and path.exists() else {}
    if key not in table:
        table[key] = asdict(ask())
        if path:
            part = path.with_suffix(".part")
            part.write_text(json.dumps(table))
            part.replace(path)
    found = table[key]
    return Fleet(**{**found, "said": [Said(**one) for one in found["said"]]})
