"""Run independent tasks in parallel within a time limit, with results even if they are interrupted."""

import os
import pickle
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from contextvars import ContextVar
from ctypes import c_double
from multiprocessing import get_context
from queue import SimpleQueue
from threading import Event, current_thread, main_thread
from typing import Any, NamedTuple

from exidyn.identification.child_processes import process_pool

from ..errors import TrajectoryError

Stop = Callable[[], bool]
"""Whether a task is asked to end with its best result."""
Report = Callable[[Any], None]
"""Sends a value to the caller while the task runs."""

POLL = 0.2
"""Interval at which the clock is checked while tasks run [s], far below the duration of a start."""


class Shared(NamedTuple):
    """What the workers of a pool share with the caller."""

    stopping: Any  # event that asks running tasks to end
    begun: Any  # start of the first task on the clock that all processes share [s]; 0 before
    reports: Any  # queue of the values that tasks report


SHARED = ContextVar[Shared]("shared by a worker with the caller of its pool")


def run_all(
    work: Callable[..., Any],
    tasks: Sequence[tuple[Any, ...]],
    seconds: float,
    note: Callable[[Any], None],
    receive: Report = lambda _: None,
) -> None:
    """Call work(*task, seconds, stop, report) for each task; `note` gets each result as soon as it is there.

    At the end of the time, or on Ctrl-C, running tasks are requested to end with their best result, and tasks
    that have not begun are skipped. Each task gets a share of the time that remains when it begins, so that
    later tasks use the time that earlier ones did not need. One task, or one core, needs no other process.

    Args:
        work: Function to call; other processes must be able to import it.
        tasks: Arguments of each call.
        seconds: Time for all tasks, from the start of the first, as processes take seconds to start [s].
        note: Called in this thread with each result.
        receive: Called in this thread with the values that tasks report.

    Raises:
        TrajectoryError: A process of the pool died.
    """
    workers = max(min(len(tasks), os.cpu_count() or 1), 1)
    rounds = [-(-(len(tasks) - place) // workers) for place in range(len(tasks))]
    with _interrupt_noted() as interrupted, _pool(workers, tasks) as (pool, shared):
        try:
            with _interrupts_blocked():  # an interrupt would kill a process that still imports
                futures = [
                    pool.submit(_call_in_time, work, task, seconds, task_rounds)
                    for task, task_rounds in zip(tasks, rounds, strict=True)
                ]
            _gather(futures, seconds, note, receive, shared, interrupted)
        except BrokenProcessPool as error:
            raise TrajectoryError(
                "a process of the search died: memory may have run out, or a script that defines an effect "
                "has no guard. Try fewer starts, move the effect to its own module, or call the search under "
                "`if __name__ == '__main__':`"
            ) from error
        finally:
            shared.stopping.set()  # tasks that still run after an error end now, not at the end of their time


@contextmanager
def _pool(workers: int, tasks: Sequence[tuple[Any, ...]]) -> Iterator[tuple[Executor, Shared]]:
    """A pool of processes, or one thread for one worker, that has ended when the block ends."""
    if workers == 1:
        shared = Shared(Event(), c_double(), SimpleQueue())
        with ThreadPoolExecutor(1, initializer=SHARED.set, initargs=(shared,)) as thread:
            yield thread, shared
        return
    context = get_context("spawn")
    shared = Shared(context.Event(), context.RawValue("d"), context.SimpleQueue())
    of_script = b"__main__" in pickle.dumps(tasks)  # such as an effect that a script defines
    with _one_thread_each(), process_pool(workers, _begin_process, (shared,), of_script) as pool:
        yield pool, shared


def _gather(
    futures: Sequence["Future[Any]"],
    seconds: float,
    note: Callable[[Any], None],
    receive: Report,
    shared: Shared,
    interrupted: Stop,
) -> None:
    """Pass on results as they arrive, until the time from the first start is over."""
    pending = set(futures)
    try:
        while pending:
            done, pending = wait(pending, timeout=POLL, return_when="FIRST_COMPLETED")
            while not shared.reports.empty():
                receive(shared.reports.get())
            for future in done:
                note(future.result())
            begun = shared.begun.value
            time_is_over = begun > 0.0 and time.monotonic() > begun + seconds
            if (time_is_over or interrupted()) and not shared.stopping.is_set():
                shared.stopping.set()
                pending = {future for future in pending if not future.cancel()}
    finally:
        for future in pending:
            future.cancel()  # after an error


def _call_in_time(work: Callable[..., Any], task: tuple[Any, ...], seconds: float, rounds: int) -> Any:
    """Call work with a share of the remaining time of all tasks; this worker has `rounds` tasks to come."""
    shared = SHARED.get()
    # Workers that begin at the same time may all write: their times differ by less than a millisecond.
    shared.begun.value = shared.begun.value or time.monotonic()
    remaining = max(shared.begun.value + seconds - time.monotonic(), 0.0)
    return work(*task, remaining / rounds, shared.stopping.is_set, shared.reports.put)


def _begin_process(shared: Shared) -> None:
    """Initialize a process of the pool, in which interrupts are ignored: the parent handles them."""
    SHARED.set(shared)
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _interrupt_noted() -> Iterator[Stop]:
    """Yield a function that tells whether Ctrl-C was pressed, to end work early; a second press raises."""
    pressed: list[int] = []

    def on_interrupt(*_: object) -> None:
        pressed.append(1)
        if len(pressed) > 1:
            raise KeyboardInterrupt

    if current_thread() is not main_thread():  # Python handles signals in the main thread only
        yield lambda: False
        return
    before = signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Defer Ctrl-C until the end of the block; processes started inside never receive it."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Make processes started inside run linear algebra on one thread, so that they do not compete."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    before = {name: os.environ[name] for name in names if name in os.environ}
    os.environ.update(dict.fromkeys(names, "1"))
    try:
        yield
    finally:
        for name in names:
            del os.environ[name]
        os.environ.update(before)
