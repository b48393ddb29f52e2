"""Fleet: wear put into simulated arms: is it found, when, under its name; and what a run costs."""

import os
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy

import numpy as np
from common import parser, save, show
from parts.fleet.arms import Arm, arm
from parts.fleet.engine import engine_figures
from parts.fleet.figures import drift_figures, same_arm
from parts.fleet.hard import alarm_figures, asked, hard_figures, kept
from parts.fleet.real import ur10e
from parts.fleet.seasons import check_run, season

from exidyn.identification.fleet.learned import learned
from exidyn.identification.fleet.report import KindReport
from exidyn.identification.fleet.runs import Frame

ARMS, WEEKS, BEGIN = 20, 26, 10.0
"""Of each of two types; weeks of runs; the week in which wear begins."""
QUICK_ARMS, QUICK_WEEKS, QUICK_BEGIN = 6, 12, 6.0
RATE = 1.0
"""False alarms an arm and year that are allowed of the seasons."""
HARD, HARD_ARMS, HARD_WEEKS, HARD_BEGIN = 4, 30, 26, 10
"""Hard fleets of each type; arms of each; weeks; in which of them causes begin."""
QUICK_HARD = ("cobot", 12, 20)
JUDGED = 9000
"""Seeds of what is judged begin here; those below 1000 were looked at while this was built."""
SOUND = 20_000
"""The same of fleets of which nothing changes."""
TOP = (
    "false_alarms_per_arm_decade",
    "false_alarms_per_arm_decade_at_most_95",
    "weeks_to_find_creep",
    "changes_per_cause",
)


def seasons(given: Any) -> dict[str, Any]:
    """Half a year of two types of arms."""
    count, weeks, begin = (QUICK_ARMS, QUICK_WEEKS, QUICK_BEGIN) if given.quick else (ARMS, WEEKS, BEGIN)
    arms: dict[str, Arm] = {}
    reports, seconds = [], {}
    for kind in ("cobot", "kr270"):
        own = {one.name: one for one in (arm(kind, number) for number in range(count))}
        arms |= own
        runs = {name: season(kind, one, weeks, begin) for name, one in own.items()}
        for share in (1.0,) if given.quick else (0.5, 1.0):
            some = dict(list(runs.items())[: round(share * count)])
            start = time.process_time()
            frame = Frame.of(check_run(kind, False).kind, [run for every in some.values() for run in every])
            report = KindReport.of(kind, learned(frame, some), RATE)
            seconds[share] = seconds.get(share, 0.0) + time.process_time() - start
        reports.append(report)
    found = drift_figures(reports, arms, begin) | same_arm(reports, arms)
    show(
        "Wear put in, and what was said of it",
        ["arm", "wear", "share", "weeks to find", "named", "share found"],
        found.pop("lines"),
    )
    runs_asked = 2 * count * weeks
    return found | {
        "runs": runs_asked,
        "analysis_ms_a_run": 1e3 * seconds[1.0] / runs_asked,
        "analysis_ms_a_run_of_half_the_arms": None if given.quick else 2e3 * seconds[0.5] / runs_asked,
    }


def hard(given: Any) -> dict[str, Any]:
    """Fleets as tables of fit numbers: heavy tails, exchanges, tools, bad runs, files of other arms.

    Each fleet is kept beside the JSON file as soon as it is asked: a call goes on where another ended.
    """
    fleets = [(kind, HARD_ARMS, HARD_WEEKS) for _ in range(HARD) for kind in ("cobot", "kr270")]
    path, found = _kept_in(given), []
    for place, (kind, arms, weeks) in enumerate([QUICK_HARD] if given.quick else fleets):
        seed = JUDGED + 100 * place
        found.append(
            kept(path, f"{kind} {seed} {arms} {weeks}", partial(asked, kind, seed, arms, weeks, HARD_BEGIN))
        )
    rows = [
        [one.arm, one.cause or "-", "right" if one.right else "-", one.false, one.weeks, " ".join(one.words)]
        for fleet in found
        for one in fleet.said
        if one.cause or one.false or one.statements
    ]
    show("What was said of hard fleets", ["arm", "put in", "named", "false", "weeks to find", "said"], rows)
    return hard_figures(found, HARD_BEGIN)


def sound(given: Any) -> dict[str, Any]:
    """Fleets of which nothing changes, with the same scatter: how often an alarm is raised all the same."""
    path, found = _kept_in(given), []
    for place in range(given.sound):
        kind, seed = ("cobot", "kr270")[place % 2], SOUND + 100 * place
        key = f"sound {kind} {seed} {HARD_ARMS} {HARD_WEEKS}"
        found.append(kept(path, key, partial(asked, kind, seed, HARD_ARMS, HARD_WEEKS, None)))
    return alarm_figures(found)


def _kept_in(given: Any) -> Path | None:
    return given.json.with_suffix(".fleets.json") if given.json and not given.quick else None


def engine(given: Any) -> dict[str, Any]:
    """Files, processes, cutting off."""
    with tempfile.TemporaryDirectory(prefix="fleet-") as folder:
        return engine_figures(Path(folder), *((1, 2, 0) if given.quick else (4, 10, 3)))


def real(given: Any) -> dict[str, Any]:
    """The UR10e's recordings of five months."""
    with tempfile.TemporaryDirectory(prefix="fleet-") as folder:
        return ur10e(Path(folder), RATE)


PARTS = {"hard": hard, "sound": sound, "seasons": seasons, "engine": engine, "real": real}
QUICK = ("hard", "engine")


def main() -> None:
    """Every part, print and save."""
    options = parser(__doc__ or "", PARTS)
    options.add_argument("--sound", type=int, default=4, metavar="N", help="fleets of which nothing changes")
    given = options.parse_args()
    table = {name: PARTS[name](given) for name in given.only or (QUICK if given.quick else PARTS)}
    for name, figures in table.items():
        rows = [[key, value] for key, value in figures.items() if np.isscalar(value) or value is None]
        show(name, ["figure", "value"], rows)
    top = {name: table["hard"][name] for name in TOP if "hard" in table}
    if "sound" in table:
        top["false_alarms_of_sound_fleets_per_arm_decade"] = table["sound"]["false_alarms_per_arm_decade"]
    if "engine" in table:
        top["runs_per_cpu_minute"] = table["engine"]["runs_per_cpu_minute"]
    save(given.json, top | table)


if __name__ == "__main__":
    main()
