"""Tasks side by side: every result, an end in time, and errors that reach the caller."""

import multiprocessing
import os
import signal
import time
from concurrent.futures import ThreadPoolExecutor
from ctypes import c_double
from pathlib import Path
from queue import SimpleQueue
from threading import Event
from types import SimpleNamespace

import pytest

from exidyn.trajectories.errors import TrajectoryError
from exidyn.trajectories.search import parallel
from exidyn.trajectories.search.parallel import SHARED, Shared, run_all

from ...parts.plans import parallel_work as work
from ...parts.plans.parallel_work import LONG, square, until_asked
from ...parts.plans.slow_to_import import time_until_asked

pytestmark = pytest.mark.clocked(patient=True)


@pytest.fixture
def two(monkeypatch):
    """Two processes whatever the machine has, which find what to do."""
    monkeypatch.setattr(parallel.os, "cpu_count", lambda: 2)
    monkeypatch.syspath_prepend(str(Path(__file__).parents[3]))


def collected(work, tasks, seconds=LONG):
    found = []
    run_all(work, [(task,) for task in tasks], seconds, found.append)
    return found


def test_several_run_in_other_processes_on_one_thread_each(two, monkeypatch):
    assert collected(square, []) == []
    assert [result[:2] for result in collected(square, [3])] == [(9, os.getpid())]
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    found = collected(square, [1, 2, 3])
    assert sorted(r[0] for r in found) == [1, 4, 9]
    assert os.getpid() not in {r[1] for r in found}
    assert {r[2] for r in found} == {"1"}
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "MKL_NUM_THREADS" not in os.environ
    assert not multiprocessing.active_children()


def test_at_the_end_of_the_time_running_tasks_report_what_they_have(two):
    found = collected(until_asked, [1, 2, 3, 4, 5, 6], seconds=0.5)
    assert found
    assert set(found) < {1, 2, 3, 4, 5, 6}
    assert not multiprocessing.active_children()


def test_the_time_begins_when_a_process_has_begun_to_work(two):
    """Not when it is started: to import the linear algebra alone takes longer than a short search."""
    assert max(collected(time_until_asked, [1, 2], seconds=0.3)) > 0.2


@pytest.mark.parametrize("after", [0, 4], ids=["while they begin", "while they work"])
def test_an_interrupt_of_all_processes_asks_them_to_end(two, monkeypatch, after):
    """Ctrl-C reaches the whole group; those that work must live to report what they have."""
    waits, wait = [], parallel.wait

    def interrupted(left, **named):
        waits.append(len(waits))
        if waits[-1] == after:
            while not all(future.running() for future in left):  # else the pool may leave one out
                time.sleep(0.01)
            for child in multiprocessing.active_children():
                os.kill(child.pid, signal.SIGINT)
            os.kill(os.getpid(), signal.SIGINT)
        return wait(left, **named)

    monkeypatch.setattr(parallel, "wait", interrupted)
    assert set(collected(until_asked, [1, 2])) == {1, 2}
    assert len(waits) > after + 1
    assert not multiprocessing.active_children()


def test_an_interrupt_while_a_result_is_noted_loses_no_other(two):
    """The second task works until it is asked to end, which the result of the first leads to."""
    noted = []

    def note(result):
        noted.append(result)
        if len(noted) == 1:
            os.kill(os.getpid(), signal.SIGINT)

    run_all(work.waiting_from_two, [(1,), (2,)], LONG, note)
    assert noted == [1, 2]


def test_an_error_in_a_process_is_raised_here_and_ends_the_others(two):
    with pytest.raises(ZeroDivisionError, match="one"):
        collected(work.failing, [1, 2, 3, 4])
    assert not multiprocessing.active_children()


def test_a_process_that_dies_is_reported(two):
    with pytest.raises(TrajectoryError, match="a process of the search died.*__main__"):
        collected(work.dying, [1, 2])


def test_work_in_another_thread_than_the_main_one(two):
    with ThreadPoolExecutor(1) as pool:
        found = pool.submit(collected, square, [1, 2]).result()
    assert sorted(r[0] for r in found) == [1, 4]


def test_each_task_has_its_share_of_the_time_that_is_left(monkeypatch):
    """From the start of the first: 8 s of four tasks, 5 s of three, and none of the last."""
    clock = iter([10.0, 10.0, 13.0, 20.0])
    monkeypatch.setattr(parallel, "time", SimpleNamespace(monotonic=clock.__next__))
    before = SHARED.set(Shared(Event(), c_double(), SimpleQueue()))
    told = [parallel._call_in_time(lambda seconds, *_: seconds, (), 8.0, rounds) for rounds in (4, 3, 1)]
    SHARED.reset(before)
    assert told == [8.0 / 4, 5.0 / 3, 0.0]


def test_an_interrupt_on_one_core_ends_all_tasks_with_what_the_first_has(monkeypatch):
    monkeypatch.setattr(parallel.os, "cpu_count", lambda: 1)
    before = signal.getsignal(signal.SIGINT)
    assert collected(work.pressing, [1, 2, 3]) == [1]
    with pytest.raises(KeyboardInterrupt):
        collected(work.pressing_twice, [1])
    assert signal.getsignal(signal.SIGINT) == before


@pytest.mark.parametrize("tasks", [[3], [3, 4]], ids=["here", "in other processes"])
def test_what_tasks_report_is_received_before_they_end(two, tasks):
    order = []
    run_all(
        work.reporting,
        [(task,) for task in tasks],
        LONG,
        lambda result: order.append(("ended", result)),
        lambda message: order.append(("reported", message)),
    )
    for task in tasks:
        assert order.index(("reported", 10 * task)) < order.index(("ended", task))
