"""Figures: what was found of what was put in, how soon, and what was found besides."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from exidyn.identification.fleet.compared import compared
from exidyn.identification.fleet.drift import DetectedChange
from exidyn.identification.fleet.kind import Cause
from exidyn.identification.fleet.report import KindReport

from .arms import Arm
from .recordings import START, WEEK

PAIRS = 5
"""Pairs of days of each sound arm that are compared with each other."""


def drift_figures(reports: Sequence[KindReport], arms: Mapping[str, Arm], begin: float) -> dict[str, Any]:
    """Of all arms; an alarm is false on a sound arm, before the wear began, or if its joint is another."""
    found, named, weeks, false, years, lines = 0, 0, [], 0, 0.0, []
    day = START + WEEK * begin
    for report in reports:
        causes = report.learned.frame.causes
        for name, own in report.drifts.items():
            wear, days = arms[name].wear, report.learned.arms[name].days
            years += (days[-1] - days[0]) / 365.25
            true = [one for one in own.alarms if wear is not None and one >= day]
            false += len(own.alarms) - len(true)
            if wear is None:
                continue
            best = max(own.changes, key=lambda one: one.evidence, default=None)
            right = best is not None and _where(causes, best) == wear[:2]
            found, named = found + bool(true), named + right
            weeks += [(true[0] - day) / WEEK] if true else []
            false += sum(_where(causes, one)[1] != wear.joint for one in own.changes if one.alarmed >= day)
            lines.append([name, wear.effect, wear.share, weeks[-1] if true else None, *_said(report, best)])
    return {
        "worn": len(lines),
        "drift_found": found,
        "named_right": named,
        "weeks_to_find": max(weeks, default=None),
        "weeks_to_find_mean": float(np.mean(weeks)) if weeks else None,
        "false_alarms": false,
        "arm_years": years,
        "false_alarms_per_arm_year": false / years,
        "lines": lines,
    }


def _where(causes: Sequence[Cause], found: DetectedChange) -> tuple[str, int]:
    """Effect and joint, from 1, of a change's surest consequence; of another arm none."""
    if not found.suspect.causes:
        return found.suspect.name, 0
    one = causes[found.suspect.causes[found.surest]]
    return one.effect, one.joint + 1


def _said(report: KindReport, best: DetectedChange | None) -> list[Any]:
    if best is None:
        return ["nothing", None]
    effect, joint = _where(report.learned.frame.causes, best)
    amount = best.amounts[best.surest] / abs(best.usual[best.surest]) if best.suspect.causes else None
    return [f"{effect} {joint} {best.shape}", amount]


def same_arm(reports: Sequence[KindReport], arms: Mapping[str, Arm]) -> dict[str, Any]:
    """Share of pairs of days of one sound arm between which anything is said to differ."""
    random, differs = np.random.default_rng(0), []
    for report in reports:
        for name, runs in report.learned.arms.items():
            if arms[name].wear is None:
                for _ in range(PAIRS):
                    one, other = random.choice(len(runs.runs), 2, replace=False)
                    found = compared(report.learned, runs[one : one + 1], runs[other : other + 1])
                    differs.append(bool(found))
    return {"same_arm_differs": float(np.mean(differs)) if differs else None, "same_arm_pairs": len(differs)}
