"""From kept runs to what changed, and its tables beside them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identify.errors import RecordingError
from exidyn.identify.fleet.compared import Difference, compared
from exidyn.identify.fleet.learned import Expected, Learned, learned
from exidyn.identify.fleet.report import KindReport, change_words, temperature_of
from exidyn.identify.fleet.runs import ArmRuns, Frame, Run

from .store import CHANGES, DAY, Store, place_of, utc, write_table


def reports(store: Store, alarms_per_year: float) -> list[KindReport]:
    """Of each type of arm that has runs."""
    return [
        KindReport.of(key, found, alarms_per_year)
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
    """Changes of the arms of a type, a row each."""
    causes = report.learned.frame.causes
    return [
        {
            "arm": arm,
            "kind": report.key,
            "effect": causes[one.cause].effect,
            "joint": causes[one.cause].joint + 1,
            "parameter": causes[one.cause].parameter,
            "unit": causes[one.cause].unit,
            "shape": one.shape,
            "amount": one.amount,
            "std": one.std,
            "usual": one.usual,
            "date": utc(one.day),
            "earliest": utc(one.interval[0]),
            "latest": utc(one.interval[1]),
            "alarm": utc(one.alarmed),
            "deviations": one.deviations,
            "words": change_words(report.learned, one),
        }
        for arm, own in report.drifts.items()
        for one in own.found
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
