"""The UR10e's recordings of September 2019 to February 2020 as one arm's history."""

import re
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from common import show

from exidyn.acquire.fleet.analysis import reports
from exidyn.acquire.fleet.source import Source
from exidyn.acquire.fleet.store import Store
from exidyn.acquire.fleet.work import identify_new, left_out
from exidyn.identification.errors import ExidynError
from exidyn.identification.fleet.report import KindReport, change_words, date_words
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import KnownPayload

from ..real.data import FOLDER, UR10E
from .engine import Here

DATE = re.compile(r"ur-(\d\d)_(\d\d)_(\d\d)(?:-(\d\d)_(\d\d))?")
LOADED = re.compile(r"(?<!un)load", re.IGNORECASE)


def make(folder: Path) -> list[str]:
    """Every excitation as a recording with its date; bodies are there without being known."""
    made = []
    for path in sorted((FOLDER / "ur10e_mamedov").glob("id_*.csv.gz")):
        name = path.name.removesuffix(".csv.gz")
        written = DATE.search(name)
        if written is None:
            continue
        year, month, day, hour, minute = (int(one or 12) for one in written.groups())
        begin = datetime(2000 + year, month, day, hour, minute, tzinfo=UTC).timestamp()
        payload = KnownPayload("load", ()) if LOADED.search(name) else None
        try:
            run = UR10E.run(name, payload)
        except ExidynError as error:
            print(f"{name}: {error}")
            continue
        host = np.round((begin + run.signals["position"].time) * 1e9).astype(np.int64)
        write_recording(replace(run, host_time=host), folder / "ur10e" / f"{name}.mcap")
        made.append(name)
    return made


def ur10e(folder: Path, rate: float) -> dict[str, Any]:
    """What changed between dates, with bodies and without."""
    (folder / "recordings" / "ur10e").mkdir(parents=True)
    made = make(folder / "recordings")
    found: dict[str, Any] = {"recordings": len(made)}
    for name, wanted in (("with bodies", made), ("without", [one for one in made if not LOADED.search(one)])):
        chosen = folder / name / "ur10e"
        chosen.mkdir(parents=True)
        for one in wanted:
            (chosen / f"{one}.mcap").symlink_to(folder / "recordings" / "ur10e" / f"{one}.mcap")
        store = Store(folder / f"{name} kept")
        identify_new(Source(str(folder / name)), store, Here())
        [report] = reports(store, rate)
        [own] = report.drifts.values()
        found[name] = {
            "runs": len(report.learned.arms["ur10e"].runs),
            "trust": report.learned.trust,
            "alarms": len(own.alarms),
            "changes": [change_words(report.learned, one) for one in own.changes],
            "left_out": list(left_out(store)),
        }
        print(f"{name}:", *(found[name]["changes"] or ["nothing changed"]), sep="\n  ")
        for effect in ("viscous_friction", "coulomb_friction"):
            _history(report, f"{name}: {effect}, mean of the runs of a day", effect)
    return found


def _history(report: KindReport, title: str, effect: str) -> None:
    """Print an effect of every joint by day, and how many of the runs carried a body."""
    runs, (values, _) = report.learned.arms["ur10e"], report.values("ur10e")
    places = [k for k, cause in enumerate(report.wearing) if cause.effect == effect]
    rows = []
    for day in np.unique(np.floor(runs.days)):
        here = np.floor(runs.days) == day
        means = np.mean(values[here][:, places], axis=0)
        rows.append([date_words(day), int(np.sum(here)), int(np.sum(runs.loose[here])), *means])
    joints = [f"joint {report.wearing[k].joint + 1}" for k in places]
    show(title, ["day", "runs", "with a body", *joints], rows)
