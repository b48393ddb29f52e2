"""Analysis of stored runs: changes and their tables, and the residual of a live arm."""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.drivers import Sample
from exidyn.identification.errors import ExidynError, RecordingError
from exidyn.identification.fleet.compared import Difference, compared
from exidyn.identification.fleet.drift import DetectedChange
from exidyn.identification.fleet.kind import measures_of
from exidyn.identification.fleet.learned import Expected, Learned, learned
from exidyn.identification.fleet.report import KindReport, change_words, odd_words, temperature_of
from exidyn.identification.fleet.runs import ArmRuns, Frame, Run
from exidyn.identification.fleet.summary import Summary, summarised
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording, Signal

from ..terminal.watch_text import Residual
from .store import CHANGES, DAY, Store, place_of, utc, write_table
from .work import known_kind

SIGNALS = ("position", "current", "torque", "temperature")
"""Signals of a sample that a run contains."""
DAY_NS = 86400e9
"""Duration of a day [ns]."""


def reports(store: Store, alarms_per_year: float, executor: Executor | None = None) -> list[KindReport]:
    """Reports of all types of arms with runs; the executor works on each arm separately."""
    return [
        KindReport.of(key, statistics, alarms_per_year, executor)
        for key in store.kinds()
        if (statistics := learned_of(store, key)) is not None
    ]


def learned_of(store: Store, key: str) -> Learned | None:
    """Statistics of the parameters of a type's arms; None if the type has no runs."""
    arms = store.arms(key)
    return _learned(store, key, arms) if arms else None


def _learned(store: Store, key: str, arms: Mapping[str, Sequence[Run]]) -> Learned:
    return learned(Frame.of(store.kind(key), [run for runs in arms.values() for run in runs]), arms)


def write_tables(store: Store, kind_reports: Sequence[KindReport]) -> None:
    """Write the parameter values of each run, by arm and month, and all changes."""
    for report in kind_reports:
        for arm in report.drifts:
            _write_values(store.folder / "values", report, arm)
    changes = [row for report in kind_reports for row in change_rows(report)]
    if changes:
        write_table(store.folder / CHANGES, changes)
    else:
        (store.folder / CHANGES).unlink(missing_ok=True)


def _write_values(folder: Path, report: KindReport, arm: str) -> None:
    runs, (values, stds) = report.learned.arms[arm], report.values(arm)
    temperatures, months = temperature_of(runs), dict[Path, list[dict[str, Any]]]()
    for index, run in enumerate(runs.runs):
        rows = months.setdefault(folder / place_of(arm, utc(run.day)) / "values.parquet", [])
        rows += [
            {
                "key": run.key,
                "date": utc(run.day),
                "effect": cause.effect,
                "joint": cause.joint + 1,
                "parameter": cause.parameter,
                "unit": cause.unit,
                "value": float(values[index, k]),
                "std": float(stds[index, k]),
                "temperature": float(temperatures[index]),
            }
            for k, cause in enumerate(report.wearing)
        ]
    for path, rows in months.items():
        write_table(path, rows)


def change_rows(report: KindReport) -> list[dict[str, Any]]:
    """Changes of a type's arms, one row each, described by the most certain parameter of each change."""
    return [
        {
            "arm": arm,
            "kind": report.key,
            **_surest(report, change),
            "shape": change.shape,
            "date": utc(change.day),
            "earliest": utc(change.interval[0]),
            "latest": utc(change.interval[1]),
            "alarm": utc(change.alarmed),
            "evidence": change.evidence,
            "words": change_words(report.learned, change),
        }
        for arm, drift in report.drifts.items()
        for change in drift.changes
    ]


def _surest(report: KindReport, change: DetectedChange) -> dict[str, Any]:
    """The most certain parameter of a change; without values if the arm was exchanged."""
    if not change.suspect.causes:
        names: dict[str, Any] = {"effect": change.suspect.name, "joint": 0, "parameter": "", "unit": ""}
        return names | dict.fromkeys(("amount", "std", "usual"), float("nan"))
    k = change.surest
    cause = report.learned.frame.causes[change.suspect.causes[k]]
    return {
        "effect": cause.effect,
        "joint": cause.joint + 1,
        "parameter": cause.parameter,
        "unit": cause.unit,
        "amount": float(change.amounts[k]),
        "std": float(change.stds[k]),
        "usual": float(change.usual[k]),
    }


def odd_rows(report: KindReport) -> list[dict[str, Any]]:
    """Odd runs of a type's arms, one row each."""
    return [
        {
            "arm": arm,
            "key": report.learned.arms[arm].runs[odd.run].key,
            "date": utc(odd.day),
            "words": odd_words(report.learned, odd),
        }
        for arm, drift in report.drifts.items()
        for odd in drift.odd
    ]


def differences(store: Store, first: str, second: str) -> tuple[Learned, list[Difference]]:
    """Differences of two arms; ARM@2026-05 and ARM@2026-05-03 select the runs of a month or a day.

    Raises:
        RecordingError: If an arm or its runs do not exist, or the arms are of different types.
    """
    names = [selection.partition("@")[0] for selection in (first, second)]
    for key in store.kinds():
        arms = store.arms(key)
        if all(name in arms for name in names):
            statistics = _learned(store, key, arms)
            return statistics, compared(
                statistics, *(_selected(statistics.arms, name) for name in (first, second))
            )
    _require(store, names)
    raise RecordingError(f"{names[0]} and {names[1]} are arms of different types with different parameters")


def _require(store: Store, names: Sequence[str]) -> None:
    known = sorted({arm for key in store.kinds() for arm in store.arms(key)})
    missing = [name for name in names if name not in known]
    if missing:
        raise RecordingError(
            f"no runs of {' or '.join(missing)} in {store.folder}. Arms: {', '.join(known) or 'none'}"
        )


def expected_of(store: Store, arm: str) -> tuple[str, Expected]:
    """Type of an arm, and its expected parameters from the runs since its last change.

    Raises:
        RecordingError: If the arm does not exist or has too few runs.
    """
    _require(store, [arm])
    [key] = [key for key in store.kinds() if arm in store.arms(key)][:1]
    statistics = learned_of(store, key)
    assert statistics is not None  # the type has this arm
    runs = statistics.arms[arm]
    last = max((row["date"].timestamp() / DAY for row in store.changes(arm)), default=-np.inf)
    return key, Expected.of(statistics, runs[runs.days > last])


def _selected(arms: Mapping[str, ArmRuns], name: str) -> ArmRuns:
    arm, _, when = name.partition("@")
    rows = [k for k, run in enumerate(arms[arm].runs) if utc(run.day).isoformat().startswith(when)]
    if not rows:
        raise RecordingError(f"no runs of {arm} on {when}; write a month as YYYY-MM and a day as YYYY-MM-DD")
    return arms[arm][np.array(rows)]


class ResidualAlarm:
    """Residual of a live arm, compared with its check runs.

    Args:
        store: Runs of the fleet.
        arm: Name of the arm in the fleet.
        alarms_per_year: Accepted false alarms, over all joints of an arm that always moves.
        executor: Executor with a separate process, so that the controller is answered meanwhile.

    Raises:
        RecordingError: If the arm does not exist, or has too few runs since its last change.
    """

    def __init__(self, store: Store, arm: str, alarms_per_year: float, executor: Executor) -> None:
        self.kind, self._expected = expected_of(store, arm)
        self._store, self._executor = store, executor
        self._limit = self._expected.limit(alarms_per_year)
        self._waiting: list[Sample] = []
        self._future: Future[Summary | str] | None = None
        self._day = 0.0
        unknown = np.full_like(self._limit, np.nan)
        self._latest = Residual(unknown, self._limit, self._expected.seconds, "not known yet")

    @property
    def model(self) -> Model:
        """The nominal model of the arm."""
        return self._expected.runs.frame.kind.model

    def add(self, samples: Sequence[Sample]) -> Residual:
        """Take further samples, and return the residual of the last completed section."""
        self._waiting += samples
        if self._future is None and self._long_enough():
            self._day = self._waiting[-1].host_time / DAY_NS
            rows = {name: np.array([getattr(sample, name) for sample in self._waiting]) for name in SIGNALS}
            time = 1e-9 * np.array([sample.controller_time for sample in self._waiting], float)
            self._future = self._executor.submit(_reduced, self._store, self.kind, time - time[0], rows)
            self._waiting = []
        if self._future is not None and self._future.done():
            self._latest, self._future = self._judged(self._future.result()), None
        return self._latest

    def _long_enough(self) -> bool:
        first, last = (self._waiting[k].controller_time for k in (0, -1)) if self._waiting else (0, 0)
        return 1e-9 * (last - first) >= self._expected.seconds

    def _judged(self, summary: Summary | str) -> Residual:
        if isinstance(summary, str):
            return self._latest._replace(value=np.full_like(self._limit, np.nan), why=summary)
        value = self._expected.residual(Run("live", self._day, summary))
        why = (
            ""
            if np.all(np.isfinite(value))
            else "the arm's runs have temperatures, but the controller has none"
        )
        return self._latest._replace(value=value, why=why)


def _reduced(store: Store, key: str, time: np.ndarray, rows: dict[str, np.ndarray]) -> Summary | str:
    """Summary of a section of samples, or why there is none, for instance if the arm stands."""
    kind = known_kind(store, key)
    signals = {name: Signal(time, values) for name, values in rows.items() if np.any(np.isfinite(values))}
    try:
        run = Recording("live", kind.model, signals, recorded=True)
        if measures_of(run) != kind.measures:
            return f"the arm's runs have a {kind.measures}, and the controller measures none"
        return summarised(run, kind)
    except ExidynError as error:
        return str(error)
