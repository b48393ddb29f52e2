"""Identify what is new, on any executor; each run is kept by the process that identified it."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, as_completed
from concurrent.futures.process import BrokenProcessPool
from datetime import UTC, datetime
from functools import lru_cache
from uuid import uuid4

from exidyn.identify.errors import ExidynError
from exidyn.identify.fleet.kind import Kind, kind_key
from exidyn.identify.fleet.summary import summarised
from exidyn.identify.recordings.mcap.mcap_file import read_recording

from .source import Found, Source, content_hash, date_of
from .store import Row, Store

NO_DATE = datetime(1970, 1, 1, tzinfo=UTC)
"""Of a recording that cannot be read."""


def identify_new(
    source: Source, store: Store, executor: Executor, note: Callable[[int, int], None] = lambda done, of: None
) -> int:
    """Identify each recording that the store does not have; returns how many there were.

    Args:
        source: The recordings.
        store: Where results are kept, a folder that all workers see.
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
            row = Row(key, one, date, kind, summary=summarised(recording, known_kind(store, kind)))
        except ExidynError as error:
            row = Row(key, one, date, kind, error=str(error))
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
