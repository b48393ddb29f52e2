"""Where work is done: a pool of processes on this machine, or a cluster of Dask."""

import os
import signal
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from exidyn.identify.child_processes import process_pool
from exidyn.identify.notebook import optional

LOCAL = "local"
MEMORY = "500MB"
"""Of a worker of Dask; at 95 % of that it starts anew."""
NO_PAUSE = {f"distributed.worker.memory.{name}": False for name in ("target", "spill", "pause")}
"""A worker holds no results that could be spilled, and two thirds of its memory are libraries: one that
pauses at 80 %, as is usual, would do so for ever."""
THREADS = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
"""Linear algebra of a worker stays on its core."""


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
