"""Files: how fast, what two workers gain, and whether a table is the same after being cut off."""

import os
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow.parquet as parquet
from common import imports_as_here

from exidyn.acquire.fleet.source import Source
from exidyn.acquire.fleet.store import Store
from exidyn.acquire.fleet.work import identify_new, local_cluster

from .after import after_figures
from .arms import arm
from .recordings import write

BEGIN = 3.0


class Here(Executor):
    """Work in this process, one call after the other."""

    def submit(self, work: Any, /, *arguments: Any, **named: Any) -> "Future[Any]":
        """Do it now."""
        future: Future[Any] = Future()
        future.set_result(work(*arguments, **named))
        return future


def make(folder: Path, arms: int, weeks: range) -> int:
    """Recordings of both types in these weeks; returns how many."""
    for kind in ("cobot", "kr270"):
        for number in range(arms):
            for week in weeks:
                write(folder, kind, arm(kind, number), week, BEGIN)
    return 2 * arms * len(weeks)


def engine_figures(folder: Path, arms: int, weeks: int, pairs: int) -> dict[str, Any]:
    """All of them; results in folders beside the recordings.

    Args:
        folder: Empty.
        arms: Of each type.
        weeks: Runs of each arm.
        pairs: How often one worker and two are timed, in turn; the middle of the ratios counts. With none,
            nothing is asked of Dask either.
    """
    recordings, one, alone = folder / "recordings", Store(folder / "one"), list[float]()
    source = Source(str(recordings))
    for some in (range(weeks // 2), range(weeks // 2, weeks)):
        runs = make(recordings, arms, some)
        begin = time.process_time()
        identify_new(source, one, Here())
        alone.append((time.process_time() - begin) / runs)
    runs = 2 * arms * weeks
    recorded = sum(path.stat().st_size for path in recordings.rglob("*.mcap"))
    pools = [[_pool(source, Store(folder / f"{k} {count}"), count) for count in (1, 2)] for k in range(pairs)]
    found = {
        "runs": runs,
        "runs_per_cpu_minute": 60.0 / np.mean(alone),
        "second_half_of_runs_over_first": alone[1] / alone[0],
        "bytes_a_run": sum(path.stat().st_size for path in one.runs.rglob("*.parquet")) / runs,
        "megabytes_a_recording": recorded / runs / 1e6,
        "load_average": os.getloadavg()[0],
    } | after_figures(one)
    if pools:
        found |= {
            "two_workers_over_one": float(np.median([a.wall / b.wall for a, b in pools])),
            "two_workers_over_one_by_cpu": float(np.median([a.busy / b.busy for a, b in pools])),
            "pairs": [[one._asdict() for one in pair] for pair in pools],
            "megabytes_a_worker": max(pool.megabytes for pair in pools for pool in pair),
            "dask_worker_killed_identical": _dask(source, Store(folder / "dask"), one),
        }
    return found | {"kill_resume_identical": _killed(source, folder / "killed", one, runs)}


class Pool(NamedTuple):
    """What a pool of workers took.

    Attributes:
        wall: Time [s].
        busy: CPU time of this process and of the busiest worker [s]: the time on cores that are idle.
        megabytes: Of the largest worker.
    """

    wall: float
    busy: float
    megabytes: float


def _pool(source: Source, store: Store, count: int) -> Pool:
    """So many workers that are ready."""
    with ProcessPoolExecutor(count, get_context("spawn")) as pool:
        ready = dict(pool.map(_used, [0.5] * 2 * count))
        cpu, wall = time.process_time(), time.perf_counter()
        identify_new(source, store, pool)
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
        done = dict(pool.map(_used, [0.5] * 2 * count))
    busiest = max(done[key][0] - ready.get(key, (0.0, 0.0))[0] for key in done)
    return Pool(wall, cpu + busiest, max(megabytes for _, megabytes in done.values()))


def _used(seconds: float) -> tuple[int, tuple[float, float]]:
    """A worker, its CPU time [s] and memory [MB] so far; it waits, so that every worker is asked."""
    import exidyn.acquire.fleet.work  # noqa: F401

    time.sleep(seconds)
    # not ru_maxrss, which begins with that of the process that started this one
    [most] = re.findall(r"VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text())
    return os.getpid(), (time.process_time(), int(most) / 1024)


def _dask(source: Source, store: Store, whole: Store) -> bool:
    """Whether two workers of Dask, one of them killed half-way, keep the same."""
    killed: list[int] = []
    with local_cluster(2) as client:

        def kill(done: int, of: int) -> None:
            if done >= of // 2 and not killed:
                killed.append(next(iter(client.run(os.getpid).values())))
                os.kill(killed[0], signal.SIGKILL)

        identify_new(source, store, client.get_executor(), kill)
    return bool(killed) and _table(store) == _table(whole)


def _killed(source: Source, folder: Path, whole: Store, runs: int) -> bool:
    """Whether what a command that was killed half-way has left is completed to the same."""
    command = [sys.executable, "-m", "exidyn.acquire.command_line", "fleet", source.address]
    command += ["--workers", "1", "-o", str(folder)]
    process = subprocess.Popen(
        command, start_new_session=True, env=imports_as_here(), stderr=subprocess.DEVNULL
    )
    store = Store(folder)
    while len(list(store.runs.glob("*/*/*.parquet"))) < runs // 2 and process.poll() is None:
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    identify_new(source, store, Here())
    return _table(store) == _table(whole)


def _table(store: Store) -> list[Any]:
    rows = [
        row
        for path in store.runs.glob("*/*/*.parquet")
        for row in parquet.ParquetFile(path).read().to_pylist()
    ]
    return sorted(rows, key=lambda row: row["key"])
