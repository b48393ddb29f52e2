"""Run independent tasks in parallel within a time limit, with results even if they are interrupted."""

import os
import pickle
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from contextvars import ContextVar
from math import inf
from multiprocessing import get_context
from threading import current_thread, main_thread
from typing import Any

from exidyn.identification.child_processes import process_pool

from ..errors import TrajectoryError

Stop = Callable[[], bool]

POLL = 0.2
"""Interval at which the clock is checked while tasks run [s], far below the duration of a start."""

SHARED = ContextVar[tuple[Any, Any]]("shared by a pool")
"""In a process of the pool: the event that requests the end, and the start of the first task on the clock
that all processes share [s]; 0 before."""
REPORTER = ContextVar[Callable[[Any], None]]("receiver of a task's reports", default=lambda _: None)


def run_all(
    work: Callable[..., Any],
    tasks: Sequence[tuple[Any, ...]],
    seconds: float,
    note: Callable[[Any], None],
    receive: Callable[[Any], None] = lambda _: None,
) -> None:
    """Call work(*task, seconds, stop) for every task; `note` gets each result as soon as it is available.

    At the end of the time, or on Ctrl-C, running tasks are requested to end with their best result, and tasks
    that have not begun are skipped. Each task gets a share of the time that remains when it begins, so that
    later tasks use the time that earlier ones did not need. One task, or one core, needs no other process.

    Args:
        work: Function to call; other processes must be able to import it.
        tasks: Arguments of each call.
        seconds: Time for all tasks, from the start of the first, as processes take seconds to start [s].
        note: Called in this process.
        receive: Called in this process with the values that tasks `report`.

    Raises:
        TrajectoryError: A process of the pool died.
    """
    workers = max(min(len(tasks), os.cpu_count() or 1), 1)
    if workers == 1:
        end = time.monotonic() + seconds
        with _interrupt_noted() as interrupted, _reporting_to(receive):
            for place, task in enumerate(tasks):
                remaining = end - time.monotonic()
                if place == 0 or (remaining > 0.0 and not interrupted()):
                    note(work(*task, remaining / (len(tasks) - place), interrupted))
    else:
        _in_processes(work, tasks, seconds, note, receive, workers)


def _in_processes(
    work: Callable[..., Any],
    tasks: Sequence[tuple[Any, ...]],
    seconds: float,
    note: Callable[[Any], None],
    receive: Callable[[Any], None],
    workers: int,
) -> None:
    """Run tasks in a pool of processes, which has ended when this returns or raises."""
    context = get_context("spawn")
    event, begun, reports = context.Event(), context.Value("d", 0.0), context.SimpleQueue()

    def listen() -> None:
        while not reports.empty():
            receive(reports.get())

    of_script = b"__main__" in pickle.dumps(tasks)  # such as an effect that a script defines
    with _one_thread_each(), process_pool(workers, _begin, (event, begun, reports), of_script) as pool:
        try:
            with _interrupts_blocked():  # an interrupt would kill a process that still imports
                rounds = [-(-(len(tasks) - place) // workers) for place in range(len(tasks))]
                futures = [
                    pool.submit(_call_in_time, work, task, seconds, task_rounds)
                    for task, task_rounds in zip(tasks, rounds, strict=True)
                ]
            _gather(futures, seconds, note, event.set, listen, lambda: begun.value)
        except BrokenProcessPool as error:
            raise TrajectoryError(
                "a process of the search died: memory may have run out, or a script that defines an effect "
                "has no guard. Try fewer starts, move the effect to its own module, or call the search under "
                "`if __name__ == '__main__':`"
            ) from error
        finally:
            event.set()  # tasks that still run after an error end now, not at the end of their time


def _gather(
    futures: Sequence["Future[Any]"],
    seconds: float,
    note: Callable[[Any], None],
    ask_to_stop: Callable[[], None],
    listen: Callable[[], None],
    begun: Callable[[], float],
) -> None:
    """Pass on results as they arrive; stop when the time is over, which counts from the first start."""
    end, pending, stopped = inf, set(futures), False
    try:
        while pending:
            try:
                if end == inf and begun():
                    end = begun() + seconds
                done = wait(pending, timeout=POLL, return_when="FIRST_COMPLETED").done
                listen()
                while done:
                    future = done.pop()
                    pending.discard(future)
                    note(future.result())
                enough = time.monotonic() > end
            except KeyboardInterrupt:
                if stopped:
                    raise  # second interrupt
                enough = True
            if enough and not stopped:
                stopped = True
                ask_to_stop()
                pending = {future for future in pending if not future.cancel()}
    finally:
        for future in pending:
            future.cancel()  # after an error


def _call_in_time(work: Callable[..., Any], task: tuple[Any, ...], seconds: float, rounds: int) -> Any:
    """Call work with a share of the remaining time of all tasks; this process has `rounds` tasks to come."""
    stopping, begun = SHARED.get()
    with begun.get_lock():
        begun.value = begun.value or time.monotonic()
    remaining = begun.value + seconds - time.monotonic()
    return work(*task, max(remaining, 0.0) / rounds, lambda: bool(stopping.is_set()))


def report(value: Any) -> None:
    """Send a value from a task to the process that waits for it."""
    REPORTER.get()(value)


@contextmanager
def _reporting_to(receive: Callable[[Any], None]) -> Iterator[None]:
    """Send reports of tasks in this process to `receive`."""
    before = REPORTER.set(receive)
    try:
        yield
    finally:
        REPORTER.reset(before)


def _begin(event: Any, begun: Any, reports: Any) -> None:
    """Initialize a process of the pool, in which interrupts are ignored: the parent handles them."""
    SHARED.set((event, begun))
    REPORTER.set(reports.put)
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
