"""From kept runs to what changed, its tables beside them, and a live arm's residual held against them."""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.drivers import Sample
from exidyn.identification.errors import ExidynError, RecordingError
from exidyn.identification.fleet.compared import Difference, compared
from exidyn.identification.fleet.drift import Found
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
"""What of a sample a run is made of."""
DAY_NS = 86400e9


def reports(store: Store, alarms_per_year: float, executor: Executor | None = None) -> list[KindReport]:
    """Of each type of arm that has runs; arms are tasks of the executor."""
    return [
        KindReport.of(key, found, alarms_per_year, executor)
        for key in store.kinds()
        if (found := learned_of(store, key)) is not None
    ]


def learned_of(store: Store, key: str) -> Learned | None:
    """What the arms of a type teach about each other; None where it has no runs."""
    arms = store.arms(key)
    return _learned(store, key, arms) if arms else None


def _learned(store: Store, key: str, arms: Mapping[str, Sequence[Run]]) -> Learned:
    return learned(Frame.of(store.kind(key), [run for runs in arms.values() for run in runs]), arms)


def write_tables(store: Store, found: Sequence[KindReport]) -> None:
    """Values a run, by arm and month; and all changes."""
    for report in found:
        for arm in report.drifts:
            _write_values(store.folder / "values", report, arm)
    changes = [row for report in found for row in change_rows(report)]
    if changes:
        write_table(store.folder / CHANGES, changes)
    else:
        (store.folder / CHANGES).unlink(missing_ok=True)


def _write_values(folder: Path, report: KindReport, arm: str) -> None:
    runs, (values, stds) = report.learned.arms[arm], report.values(arm)
    warm, months = temperature_of(runs), dict[Path, list[dict[str, Any]]]()
    for place, run in enumerate(runs.runs):
        rows = months.setdefault(folder / place_of(arm, utc(run.day)) / "values.parquet", [])
        rows += [
            {
                "key": run.key,
                "date": utc(run.day),
                "effect": cause.effect,
                "joint": cause.joint + 1,
                "parameter": cause.parameter,
                "unit": cause.unit,
                "value": float(values[place, k]),
                "std": float(stds[place, k]),
                "temperature": float(warm[place]),
            }
            for k, cause in enumerate(report.scattering)
        ]
    for path, rows in months.items():
        write_table(path, rows)


def change_rows(report: KindReport) -> list[dict[str, Any]]:
    """Changes of the arms of a type, a row each, by the surest of what each changed."""
    return [
        {
            "arm": arm,
            "kind": report.key,
            **_surest(report, one),
            "shape": one.shape,
            "date": utc(one.day),
            "earliest": utc(one.interval[0]),
            "latest": utc(one.interval[1]),
            "alarm": utc(one.alarmed),
            "evidence": one.evidence,
            "words": change_words(report.learned, one),
        }
        for arm, own in report.drifts.items()
        for one in own.found
    ]


def _surest(report: KindReport, found: Found) -> dict[str, Any]:
    """Of another arm all parameters are other ones."""
    if not found.suspect.causes:
        names: dict[str, Any] = {"effect": found.suspect.name, "joint": 0, "parameter": "", "unit": ""}
        return names | dict.fromkeys(("amount", "std", "usual"), float("nan"))
    k = found.surest
    cause = report.learned.frame.causes[found.suspect.causes[k]]
    return {
        "effect": cause.effect,
        "joint": cause.joint + 1,
        "parameter": cause.parameter,
        "unit": cause.unit,
        "amount": float(found.amounts[k]),
        "std": float(found.stds[k]),
        "usual": float(found.usual[k]),
    }


def odd_rows(report: KindReport) -> list[dict[str, Any]]:
    """Runs out of line of the arms of a type, a row each."""
    return [
        {
            "arm": arm,
            "key": report.learned.arms[arm].runs[one.run].key,
            "date": utc(one.day),
            "words": odd_words(report.learned, one),
        }
        for arm, own in report.drifts.items()
        for one in own.odd
    ]


def differences(store: Store, first: str, second: str) -> tuple[Learned, list[Difference]]:
    """Where two arms differ; ARM@2026-05 and ARM@2026-05-03 are those of a month or a day alone.

    Raises:
        RecordingError: No such arm, no such runs, or arms of two types.
    """
    names = [one.partition("@")[0] for one in (first, second)]
    for key in store.kinds():
        arms = store.arms(key)
        if all(name in arms for name in names):
            found = _learned(store, key, arms)
            return found, compared(found, *(_selected(found.arms, one) for one in (first, second)))
    _require(store, names)
    raise RecordingError(
        f"{names[0]} and {names[1]} are arms of two types, whose parameters are not the same"
    )


def _require(store: Store, names: Sequence[str]) -> None:
    known = sorted({arm for key in store.kinds() for arm in store.arms(key)})
    missing = [name for name in names if name not in known]
    if missing:
        raise RecordingError(
            f"no runs of {' or '.join(missing)} in {store.folder}. Arms: {', '.join(known) or 'none'}"
        )


def expected_of(store: Store, arm: str) -> tuple[str, Expected]:
    """Type of an arm, and what its runs since its last change show.

    Raises:
        RecordingError: No such arm, or too few runs.
    """
    _require(store, [arm])
    [key] = [key for key in store.kinds() if arm in store.arms(key)][:1]
    found = learned_of(store, key)
    assert found is not None  # it has the arm
    runs = found.arms[arm]
    last = max((row["date"].timestamp() / DAY for row in store.changes(arm)), default=-np.inf)
    return key, Expected.of(found, runs[runs.days > last])


def _selected(arms: Mapping[str, ArmRuns], name: str) -> ArmRuns:
    arm, _, when = name.partition("@")
    rows = [k for k, run in enumerate(arms[arm].runs) if utc(run.day).isoformat().startswith(when)]
    if not rows:
        raise RecordingError(f"no runs of {arm} on {when}; a month is YYYY-MM and a day YYYY-MM-DD")
    return arms[arm][np.array(rows)]


class ResidualAlarm:
    """Takes samples as they come.

    Args:
        store: Runs of the fleet.
        arm: Name of the arm in it.
        alarms_per_year: False alarms to accept, over all joints of an arm that always moves.
        executor: A process apart: a controller that must be answered is answered meanwhile.

    Raises:
        RecordingError: No such arm, or too few runs since its last change.
    """

    def __init__(self, store: Store, arm: str, alarms_per_year: float, executor: Executor) -> None:
        self.kind, self._expected = expected_of(store, arm)
        self._store, self._executor = store, executor
        self._limits = self._expected.limits(alarms_per_year)
        self._waiting: list[Sample] = []
        self._future: Future[Summary | str] | None = None
        self._day = 0.0
        nothing = np.full_like(self._limits.alarm, np.nan)
        self._latest = Residual(nothing, self._limits.alarm, self._expected.seconds, "not known yet")

    @property
    def model(self) -> Model:
        """The nominal arm."""
        return self._expected.runs.frame.kind.model

    def add(self, samples: Sequence[Sample]) -> Residual:
        """The residual of the last piece that is known by now."""
        self._waiting += samples
        if self._future is None and self._long_enough():
            self._day = self._waiting[-1].host_time / DAY_NS
            rows = {name: np.array([getattr(one, name) for one in self._waiting]) for name in SIGNALS}
            time = 1e-9 * np.array([one.controller_time for one in self._waiting], float)
            self._future = self._executor.submit(_reduced, self._store, self.kind, time - time[0], rows)
            self._waiting = []
        if self._future is not None and self._future.done():
            self._latest, self._future = self._judged(self._future.result()), None
        return self._latest

    def _long_enough(self) -> bool:
        first, last = (self._waiting[k].controller_time for k in (0, -1)) if self._waiting else (0, 0)
        return 1e-9 * (last - first) >= self._expected.seconds

    def _judged(self, found: Summary | str) -> Residual:
        if isinstance(found, str):
            return self._latest._replace(value=np.full_like(self._limits.alarm, np.nan), why=found)
        value = self._expected.residual(Run("live", self._day, found))
        why = "" if np.all(np.isfinite(value)) else "the arm's runs have temperatures, and this has none"
        return self._latest._replace(value=value, why=why)


def _reduced(store: Store, key: str, time: np.ndarray, rows: dict[str, np.ndarray]) -> Summary | str:
    """A piece as a run is, or why it cannot be one: an arm that stands, for instance."""
    kind = known_kind(store, key)
    signals = {name: Signal(time, values) for name, values in rows.items() if np.any(np.isfinite(values))}
    try:
        run = Recording("live", kind.model, signals, recorded=True)
        if measures_of(run) != kind.measures:
            return f"the arm's runs have a {kind.measures}, and the controller measures none"
        return summarised(run, kind)
    except ExidynError as error:
        return str(error)
