"""Work on runs in a pool of processes or a cluster of Dask; the process that identified a run keeps it."""

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
from .source import Found, Source, content_hash, date_of
from .store import Row, Store

LOCAL = "local"
MEMORY = "500MB"
"""Of a worker of Dask; at 95 % of that it starts anew."""
NO_PAUSE = {f"distributed.worker.memory.{name}": False for name in ("target", "spill", "pause")}
"""A worker holds no results that could be spilled, and two thirds of its memory are libraries: one that
pauses at 80 %, as is usual, would do so for ever."""
THREADS = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
"""Linear algebra of a worker stays on its core."""
NO_DATE = datetime(1970, 1, 1, tzinfo=UTC)
"""Of a recording that cannot be read."""
REPORTS = "reports"
"""Their folder in the store's."""


@contextmanager
def executor_of(cluster: str | None, workers: int | None) -> Iterator[Executor]:
    """An executor for as long as the context lasts.

    Args:
        cluster: Address of a Dask scheduler, or `LOCAL` for one started here; None for a pool of processes.
        workers: Processes on this machine; as many as cores by default.

    Raises:
        MissingPackage: A cluster is asked for, and Dask is not installed.
    """
    os.environ.update({name: os.environ.get(name, one) for name, one in THREADS.items()})
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
    """A client of so many workers of Dask on this machine."""
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
def process_apart() -> Iterator[Executor]:
    """One process beside this one, which Ctrl-C does not end before it."""
    with process_pool(1, signal.signal, (signal.SIGINT, signal.SIG_IGN)) as pool:
        yield pool


def identify_new(
    source: Source, store: Store, executor: Executor, note: Callable[[int, int], None] = lambda done, of: None
) -> int:
    """Identify each recording that the store, which all workers see, does not have; how many there were.

    Args:
        source: The recordings.
        store: Where results are kept.
        executor: Where to work.
        note: Called with the number done, and of how many.

    Raises:
        ExidynError: A worker died.
    """
    new = _new(source, store)
    _learn_kinds(source, store, executor, list({one.arm: one for one in reversed(new)}.values()))
    left, done, begun = new, 0, uuid4().hex
    while left:
        strange = []
        futures = {executor.submit(identify_one, source, store, one, begun): one for one in left}
        try:
            for future in as_completed(futures):
                strange += [futures[future]] if future.result() else []
                done += not future.result()
                note(done, len(new))
        except BrokenProcessPool as error:
            raise ExidynError(
                "a worker died: memory may have run out. What was identified is kept; the same command goes "
                "on from there, with fewer --workers if need be"
            ) from error
        finally:
            for future in futures:
                future.cancel()
        left = sorted(strange)
        _learn_kinds(source, store, executor, left)
    store.merge()
    return len(new)


def _new(source: Source, store: Store) -> list[Found]:
    """Files that are not known as they are; one that was copied or touched is found out by its content."""
    known = {(row["file"], row["size"], row["modified"]) for row in store.index().values()}
    return [one for one in source.files() if (one.path, one.size, one.modified) not in known]


def _learn_kinds(source: Source, store: Store, executor: Executor, files: Iterable[Found]) -> None:
    """Keep the types of arms among recordings, each by the first, the same however work is divided."""
    ordered, known = sorted(files), set(store.kinds())
    futures = [executor.submit(_kind_of, source, one) for one in ordered]
    for one, future in zip(ordered, futures, strict=True):
        key = future.result()
        if key and key not in known:
            with source.local(one) as path:
                store.write_kind(key, Kind.of(read_recording(path)))
            known.add(key)


def _kind_of(source: Source, one: Found) -> str:
    try:
        with source.local(one) as path:
            return kind_key(read_recording(path))
    except ExidynError:
        return ""


def identify_one(source: Source, store: Store, one: Found, begun: str) -> str:
    """Identify a recording and keep it, or why that cannot be done; or the type of its arm if not known.

    `begun` names the call of `identify_new`: processes of a cluster outlive it.
    """
    with source.local(one) as path:
        key = content_hash(path)
        if key in _keys(store, begun):  # a copy
            return ""
        date, kind = NO_DATE, ""
        try:
            recording = read_recording(path)
            date, kind = date_of(recording, one.path), kind_key(recording)
            if kind not in store.kinds():
                return kind
            summary = summarised(recording, known_kind(store, kind))
            row = Row(key, one, date, kind, note="; ".join(recording.warnings), summary=summary)
        except ExidynError as error:
            row = Row(key, one, date, kind, error=str(error).replace(str(path), one.path))
        store.write_run(row)
    return ""


@lru_cache(maxsize=1)
def _keys(store: Store, begun: str) -> frozenset[str]:
    """What was known when this process began to work for that call."""
    return frozenset(store.index())


@lru_cache(maxsize=64)
def known_kind(store: Store, key: str) -> Kind:
    """A type of arm, read once in a process."""
    return store.kind(key)


def left_out(store: Store) -> Iterator[tuple[str, str]]:
    """File of each recording that could not be identified, and why."""
    for row in store.index().values():
        if row["error"]:
            yield row["file"], row["error"]


def not_whole(store: Store) -> Iterator[tuple[str, str]]:
    """File of each recording that was used though part of it is missing, and what."""
    for row in store.index().values():
        if row["note"] and not row["error"]:
            yield row["file"], row["note"]


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
