"""Identification of runs in a process pool or a Dask cluster; the process that identifies a run stores it."""

import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import Any
from uuid import uuid4

from exidyn.identification.child_processes import process_pool
from exidyn.identification.errors import ExidynError
from exidyn.identification.file_names import unique_stem
from exidyn.identification.fit.estimators.bayesian import posterior
from exidyn.identification.fit.identification import identify
from exidyn.identification.fleet.kind import Kind, kind_key
from exidyn.identification.fleet.summary import summarised
from exidyn.identification.notebook import optional
from exidyn.identification.pages.fit_document import report_html
from exidyn.identification.recordings.mcap.mcap_file import read_recording

from ..terminal.json_output import write_whole
from .source import Source, SourceFile, content_hash, date_of
from .store import Store
from .store_schema import IndexRow

LOCAL = "local"
"""Value of --cluster that starts a Dask cluster on this machine."""
MEMORY = "500MB"
"""Memory of a Dask worker; it restarts at 95 % of it."""
NO_PAUSE = {f"distributed.worker.memory.{name}": False for name in ("target", "spill", "pause")}
"""Settings without pauses: a worker holds no results to spill, and two thirds of its memory are libraries, so
that the default pause at 80 % would never end."""
THREADS = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
"""Environment that keeps the linear algebra of a worker on its core."""
NO_DATE = datetime(1970, 1, 1, tzinfo=UTC)
"""Date of a recording that cannot be read."""
REPORTS = "reports"
"""Folder of the reports in the store's folder."""


@contextmanager
def executor_of(cluster: str | None, workers: int | None) -> Iterator[Executor]:
    """An executor within the context.

    Args:
        cluster: Address of a Dask scheduler, or `LOCAL` to start one here; None for a process pool.
        workers: Number of processes on this machine; by default the number of cores.

    Raises:
        MissingPackage: If a cluster is requested and Dask is not installed.
    """
    os.environ.update({name: os.environ.get(name, default) for name, default in THREADS.items()})
    count = workers or os.cpu_count() or 1
    if cluster is None:
        with process_pool(count) as pool:
            yield pool
        return
    if cluster == LOCAL:
        with local_cluster(count) as client:
            yield client.get_executor()
        return
    with optional("distributed", "--cluster", "cluster").Client(cluster) as client:
        yield client.get_executor()


@contextmanager
def local_cluster(count: int) -> Iterator[Any]:
    """A client of `count` Dask workers on this machine."""
    distributed, dask = (optional(name, "--cluster", "cluster") for name in ("distributed", "dask"))
    with (
        dask.config.set(NO_PAUSE),
        distributed.LocalCluster(
            n_workers=count, threads_per_worker=1, memory_limit=MEMORY, dashboard_address=None
        ) as local,
        distributed.Client(local) as client,
    ):
        yield client


@contextmanager
def separate_process() -> Iterator[Executor]:
    """An executor with one process that ignores Ctrl-C, so that it does not end before this one."""
    with process_pool(1, signal.signal, (signal.SIGINT, signal.SIG_IGN)) as pool:
        yield pool


def identify_new(
    source: Source, store: Store, executor: Executor, note: Callable[[int, int], None] = lambda done, of: None
) -> int:
    """Identify each recording that is not in the store, and return their number.

    Args:
        source: Source of the recordings.
        store: Store of the results; all workers must see its folder.
        executor: Executor of the work.
        note: Function that takes the number of identified recordings and the total.

    Raises:
        ExidynError: If a worker died.
    """
    new = _new(source, store)
    _learn_kinds(source, store, executor, list({file.arm: file for file in reversed(new)}.values()))
    pending, done, call = new, 0, uuid4().hex
    while pending:
        unknown_kind = []
        futures = {executor.submit(identify_file, source, store, file, call): file for file in pending}
        try:
            for future in as_completed(futures):
                unknown_kind += [futures[future]] if future.result() else []
                done += not future.result()
                note(done, len(new))
        except BrokenProcessPool as error:
            raise ExidynError(
                "a worker died: memory may have run out. Identified runs are stored; the same command "
                "continues from there, with fewer --workers if necessary"
            ) from error
        finally:
            for future in futures:
                future.cancel()
        pending = sorted(unknown_kind)
        _learn_kinds(source, store, executor, pending)
    store.merge()
    return len(new)


def _new(source: Source, store: Store) -> list[SourceFile]:
    """Files whose path, size or time is not in the store; copies are recognized later by their content."""
    known = {(row.file, row.size, row.modified) for row in store.index().values()}
    return [file for file in source.files() if (file.path, file.size, file.modified) not in known]


def _learn_kinds(source: Source, store: Store, executor: Executor, files: Iterable[SourceFile]) -> None:
    """Store each type of arm from its first recording, so that the result does not depend on scheduling."""
    ordered, known = sorted(files), set(store.kinds())
    futures = [executor.submit(_kind_of, source, file) for file in ordered]
    for file, future in zip(ordered, futures, strict=True):
        key = future.result()
        if key and key not in known:
            with source.local(file) as path:
                store.write_kind(key, Kind.of(read_recording(path)))
            known.add(key)


def _kind_of(source: Source, file: SourceFile) -> str:
    try:
        with source.local(file) as path:
            return kind_key(read_recording(path))
    except ExidynError:
        return ""


def identify_file(source: Source, store: Store, file: SourceFile, call: str) -> str:
    """Identify a recording and store the result or the error.

    Args:
        source: Source of the recording.
        store: Store of the result.
        file: File of the recording.
        call: Name of the call of `identify_new`; processes of a cluster outlive it.

    Returns:
        The type of the arm if the store does not have it, and nothing was stored; otherwise empty.
    """
    with source.local(file) as path:
        key = content_hash(path)
        if key in _keys(store, call):  # a copy
            return ""
        date, kind, error, note, summary = NO_DATE, "", "", "", None
        try:
            recording = read_recording(path)
            date, kind = date_of(recording, file.path), kind_key(recording)
            if kind not in store.kinds():
                return kind
            summary = summarised(recording, known_kind(store, kind))
            note = "; ".join(recording.warnings)
        except ExidynError as reason:
            error = str(reason).replace(str(path), file.path)
        row = IndexRow(key, date, kind, file.path, file.size, file.modified, error, note, file.arm)
        store.write_run(row, summary)
    return ""


@lru_cache(maxsize=1)
def _keys(store: Store, call: str) -> frozenset[str]:
    """Keys of the store when this process began to work for a call of `identify_new`."""
    return frozenset(store.index())


@lru_cache(maxsize=64)
def known_kind(store: Store, key: str) -> Kind:
    """A type of arm, read once per process."""
    return store.kind(key)


def left_out(store: Store) -> Iterator[tuple[str, str]]:
    """Each recording that could not be identified, and why."""
    for row in store.index().values():
        if row.error:
            yield row.file, row.error


def not_whole(store: Store) -> Iterator[tuple[str, str]]:
    """Each recording that was used although part of it is missing, and the missing part."""
    for row in store.index().values():
        if row.note and not row.error:
            yield row.file, row.note


def last_runs(store: Store) -> dict[str, IndexRow]:
    """The last identified run of each arm."""
    rows = sorted(store.index().values(), key=lambda row: row.date)
    return {row.arm: row for row in rows if not row.error}


def report_path(store: Store, row: IndexRow) -> Path:
    """Path of a run's report; each run of an arm has its own."""
    return store.folder / REPORTS / unique_stem(row.arm, "arm") / f"{row.key}.html"


def write_reports(
    source: Source, store: Store, executor: Executor, note: Callable[[int, int], None]
) -> list[tuple[str, str]]:
    """Write missing reports of the last runs; return the arms without a report, and why."""
    missing = [row for row in last_runs(store).values() if not report_path(store, row).exists()]
    futures = {executor.submit(_write, source, store, row): row.arm for row in missing}
    failed = []
    for done, future in enumerate(as_completed(futures), 1):
        if why := future.result():
            failed.append((futures[future], why))
        note(done, len(missing))
    return sorted(failed)


def _write(source: Source, store: Store, row: IndexRow) -> str:
    """Replace an arm's report by that of a run; return why it is impossible, or an empty text."""
    path, kind = report_path(store, row), known_kind(store, row.kind)
    try:
        with source.local(SourceFile(row.file, row.arm, row.size, row.modified)) as copy:
            run = read_recording(copy)
        fit = identify([run], model=kind.model, estimator=posterior, filtering=kind.filtering)
    except (ExidynError, OSError) as error:
        return str(error)
    path.parent.mkdir(parents=True, exist_ok=True)
    for old in path.parent.glob("*.html"):
        old.unlink()
    write_whole(path, report_html(fit))
    return ""
