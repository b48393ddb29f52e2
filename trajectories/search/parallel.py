"""Run independent starts side by side, within a time, with an answer when it is cut short."""

import os
import pickle
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from math import inf
from multiprocessing import get_context
from threading import current_thread, main_thread
from typing import Any

from exidyn.identification.child_processes import process_pool

from ..errors import TrajectoryError

Stop = Callable[[], bool]

POLL = 0.2
"""How often the clock is looked at while starts run [s]: far below what a start takes."""

_stopping: Any = None
"""In a process of the pool: the event that asks it to end."""
_begun: Any = None
"""In a process of the pool: when the first task began by the clock that all processes share [s]; 0 before."""
_reporter: Callable[[Any], None] = lambda _: None  # noqa: E731
"""Where reports of a task go."""


def run_all(
    work: Callable[..., Any],
    tasks: Sequence[tuple[Any, ...]],
    seconds: float,
    executor: Executor | None,
    note: Callable[[Any], None],
    receive: Callable[[Any], None] = lambda _: None,
) -> None:
    """Call work(*task, seconds, stop) for every task; `note` gets each result as it comes.

    When the time is over, or on an interrupt from the keyboard, running tasks are asked to end with the
    best they have, and those not begun are left out. Each has a share of what time is left when it begins,
    so that what one does not need is for those after it; of an executor, whose processes share no clock, all
    have the same.

    Args:
        work: What to do; must be importable by other processes.
        tasks: Arguments of each call.
        seconds: For all together, from when the first begins: a process takes seconds to start [s].
        executor: Where to run; unless given a pool of processes, or this one for one task or on one core.
        note: Called in this process.
        receive: Called in this process with what tasks `report` while they run; not for an executor's tasks.

    Raises:
        TrajectoryError: A process of the pool died.
    """
    workers = max(min(len(tasks), os.cpu_count() or 1), 1)
    if executor is not None:
        share = seconds / max(-(-len(tasks) // workers), 1)
        _gather([executor.submit(_call, work, task, share) for task in tasks], seconds, note, lambda: None)
    elif workers == 1:
        end = time.monotonic() + seconds
        with _interrupt_noted() as asked, _reporting_to(receive):
            for place, task in enumerate(tasks):
                left = end - time.monotonic()
                if place == 0 or (left > 0.0 and not asked()):
                    note(work(*task, left / (len(tasks) - place), asked))
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
    """In a pool of processes, which is gone when this returns or raises."""
    context = get_context("spawn")
    event, begun, reports = context.Event(), context.Value("d", 0.0), context.SimpleQueue()

    def listen() -> None:
        while not reports.empty():
            receive(reports.get())

    of_script = b"__main__" in pickle.dumps(tasks)  # such as an effect that a script defines
    with _one_thread_each(), process_pool(workers, _begin, (event, begun, reports), of_script) as pool:
        try:
            with _deaf_to_interrupts():  # else it would kill a process that still imports
                rounds = [-(-(len(tasks) - place) // workers) for place in range(len(tasks))]
                futures = [
                    pool.submit(_call_in_time, work, task, seconds, of)
                    for task, of in zip(tasks, rounds, strict=True)
                ]
            _gather(futures, seconds, note, event.set, listen, lambda: begun.value)
        except BrokenProcessPool as error:
            raise TrajectoryError(
                "a process of the search died: memory may have run out, or a script that defines an effect "
                "has no guard. Try fewer starts, an effect in a module of its own, or to call from under "
                "`if __name__ == '__main__':`"
            ) from error
        finally:
            event.set()  # what still runs after an error ends now, and not at the end of its time


def _gather(
    futures: Sequence["Future[Any]"],
    seconds: float,
    note: Callable[[Any], None],
    ask_to_stop: Callable[[], None],
    listen: Callable[[], None] = lambda: None,
    begun: Callable[[], float] = time.monotonic,
) -> None:
    """Hand results on as they come; stop at the end of the time after one has begun, or on an interrupt."""
    end, left, stopped = inf, set(futures), False
    try:
        while left:
            try:
                if end == inf and begun():
                    end = begun() + seconds
                done = wait(left, timeout=POLL, return_when="FIRST_COMPLETED").done
                listen()
                while done:
                    future = done.pop()
                    left.discard(future)
                    note(future.result())
                enough = time.monotonic() > end
            except KeyboardInterrupt:
                if stopped:
                    raise  # asked twice
                enough = True
            if enough and not stopped:
                stopped = True
                ask_to_stop()
                left = {future for future in left if not future.cancel()}
    finally:
        for future in left:
            future.cancel()  # after an error


def _call(work: Callable[..., Any], task: tuple[Any, ...], seconds: float) -> Any:
    return work(*task, seconds, _asked)


def _call_in_time(work: Callable[..., Any], task: tuple[Any, ...], seconds: float, rounds: int) -> Any:
    """The same with a share of what is left of the time of all, for one of so many `rounds` still to come."""
    with _begun.get_lock():
        _begun.value = _begun.value or time.monotonic()
    left = _begun.value + seconds - time.monotonic()
    return work(*task, max(left, 0.0) / rounds, _asked)


def _asked() -> bool:
    """Whether this process was asked to end."""
    return _stopping is not None and _stopping.is_set()


def report(value: Any) -> None:
    """From inside a task, to the process that waits for it."""
    _reporter(value)


@contextmanager
def _reporting_to(receive: Callable[[Any], None]) -> Iterator[None]:
    """Reports of tasks in this process go to `receive`."""
    global _reporter
    before, _reporter = _reporter, receive
    try:
        yield
    finally:
        _reporter = before


def _begin(event: Any, begun: Any, reports: Any) -> None:
    """First thing in a process of the pool: an interrupt is the parent's to handle."""
    global _stopping, _begun, _reporter
    _stopping, _begun, _reporter = event, begun, reports.put
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _interrupt_noted() -> Iterator[Stop]:
    """Whether Ctrl-C was pressed inside, so that work here can end with what it has; a second one raises.

    A handler of the caller's own is called behind it: for whom work is a step of several.
    """
    pressed: list[int] = []

    def on_interrupt(*_: object) -> None:
        pressed.append(1)
        if len(pressed) > 1:
            raise KeyboardInterrupt

    if current_thread() is not main_thread():  # where Python hears no signals
        yield lambda: False
        return
    before = signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, before)
    if pressed and callable(before) and before is not signal.default_int_handler:
        before(signal.SIGINT, None)


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Ctrl-C waits for as long as this lasts, and processes begun inside never get it."""
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
    """Processes begun inside do their linear algebra on one thread, so as not to take each other's core."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    before = {name: os.environ[name] for name in names if name in os.environ}
    os.environ.update(dict.fromkeys(names, "1"))
    try:
        yield
    finally:
        for name in names:
            del os.environ[name]
        os.environ.update(before)
