"""A page for each arm: its last run identified alone, as `exidyn identify` reports it."""

from collections.abc import Callable
from concurrent.futures import Executor, as_completed
from pathlib import Path
from typing import Any

from exidyn.identify.errors import ExidynError
from exidyn.identify.file_names import unique_stem
from exidyn.identify.fit.estimators.bayesian import posterior
from exidyn.identify.fit.identification import identify
from exidyn.identify.pages.fit_document import report_html
from exidyn.identify.recordings.mcap.mcap_file import read_recording

from ..terminal.json_output import write_whole
from .source import Found, Source
from .store import Store
from .work import known_kind

REPORTS = "reports"
"""Their folder in the store's."""


def last_runs(store: Store) -> dict[str, dict[str, Any]]:
    """The last run of each arm that could be identified, a row of `Store.index`."""
    rows = sorted(store.index().values(), key=lambda row: row["date"])
    return {row["arm"]: row for row in rows if not row["error"]}


def report_path(store: Store, row: dict[str, Any]) -> Path:
    """Where the report of a run is; another run of the arm has another name."""
    return store.folder / REPORTS / unique_stem(row["arm"], "arm") / f"{row['key']}.html"


def write_reports(
    source: Source, store: Store, executor: Executor, note: Callable[[int, int], None]
) -> list[tuple[str, str]]:
    """Make those that are missing; returns the arms of which none can be made, and why."""
    missing = [row for row in last_runs(store).values() if not report_path(store, row).exists()]
    futures = {executor.submit(_write, source, store, row): row["arm"] for row in missing}
    failed = []
    for done, future in enumerate(as_completed(futures), 1):
        if why := future.result():
            failed.append((futures[future], why))
        note(done, len(missing))
    return sorted(failed)


def _write(source: Source, store: Store, row: dict[str, Any]) -> str:
    """Make one in place of those of earlier runs; returns why it cannot be made."""
    path, kind = report_path(store, row), known_kind(store, row["kind"])
    try:
        with source.local(Found(row["file"], row["arm"], row["size"], row["modified"])) as copy:
            run = read_recording(copy)
        fit = identify([run], model=kind.model, estimator=posterior, filtering=kind.filtering)
    except (ExidynError, OSError) as error:
        return str(error)
    path.parent.mkdir(parents=True, exist_ok=True)
    for old in path.parent.glob("*.html"):
        old.unlink()
    write_whole(path, report_html(fit))
    return ""
