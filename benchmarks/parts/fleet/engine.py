"""Files: how fast, what two workers gain, and whether a table is the same after being cut off."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from typing import Any

import pyarrow.parquet as parquet
from common import imports_as_here

from exidyn.acquire.fleet.source import Source
from exidyn.acquire.fleet.store import Store
from exidyn.acquire.fleet.work import identify_new

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


def make(folder: Path, arms: int, weeks: int) -> int:
    """Recordings of both types; returns how many."""
    for kind in ("cobot", "kr270"):
        for number in range(arms):
            for week in range(weeks):
                write(folder, kind, arm(kind, number), week, BEGIN)
    return 2 * arms * weeks


def engine_figures(folder: Path, arms: int, weeks: int) -> dict[str, Any]:
    """All of them; results in folders beside the recordings."""
    recordings = folder / "recordings"
    runs, source = make(recordings, arms, weeks), Source(str(recordings))
    one = Store(folder / "one")
    cpu, wall = time.process_time(), time.perf_counter()
    identify_new(source, one, Here())
    cpu, alone = time.process_time() - cpu, time.perf_counter() - wall
    pools = {count: _pool(source, Store(folder / f"{count} workers"), count) for count in (1, 2)}
    return {
        "runs": runs,
        "runs_per_cpu_minute": 60.0 * runs / cpu,
        "seconds_alone": alone,
        "seconds_by_workers": pools,
        "two_workers_over_one": pools[1] / pools[2],
        "load_average": os.getloadavg()[0],
        "megabytes_a_process": max(getrusage(who).ru_maxrss for who in (RUSAGE_SELF, RUSAGE_CHILDREN)) / 1024,
        "bytes_a_run": sum(path.stat().st_size for path in one.runs.rglob("*.parquet")) / runs,
        "kill_resume_identical": _killed(source, folder / "killed", one, runs),
    }


def _pool(source: Source, store: Store, count: int) -> float:
    """Wall time of so many workers that are ready [s]."""
    with ProcessPoolExecutor(count, get_context("spawn")) as pool:
        list(pool.map(_ready, [0.5] * 2 * count))
        begin = time.perf_counter()
        identify_new(source, store, pool)
        return time.perf_counter() - begin


def _ready(seconds: float) -> None:
    import exidyn.acquire.fleet.work  # noqa: F401

    time.sleep(seconds)


def _killed(source: Source, folder: Path, whole: Store, runs: int) -> bool:
    """Whether a command that was killed half-way and given again keeps the same."""
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
    subprocess.run(command, env=imports_as_here(), check=True, capture_output=True)
    return _table(store) == _table(whole)


def _table(store: Store) -> list[Any]:
    rows = [
        row
        for path in store.runs.glob("*/*/*.parquet")
        for row in parquet.ParquetFile(path).read().to_pylist()
    ]
    return sorted(rows, key=lambda row: row["key"])
