"""The floor: how late a loop in C that does nothing is, on this machine and at the same time."""

import atexit
import os
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from shutil import which

import numpy as np

from exidyn.acquire.run.realtime import PRIORITY

ALL = frozenset(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else frozenset[int]()
"""Processors that this process was given."""
APART = len(ALL) > 1
"""Whether the loop can have one of its own."""
LOOP = frozenset(sorted(ALL)[:1])


@contextmanager
def on_the_loops() -> Iterator[None]:
    """In the block, this thread and all that it starts are on the loop's processor."""
    if APART:
        os.sched_setaffinity(0, LOOP)
    try:
        yield
    finally:
        if APART:
            os.sched_setaffinity(0, ALL)


def move_away(process: int) -> None:
    """Put a process with all its threads on the other processors."""
    if not APART:
        return
    with suppress(OSError):  # threads end
        for thread in os.listdir(f"/proc/{process}/task"):
            os.sched_setaffinity(int(thread), ALL - LOOP)


MOST = 1_000_000
"""Ticks that the loop in C has room for."""
PROGRAM = r"""
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <time.h>

static volatile sig_atomic_t ended;
static double late[%d][2];
static void end(int number) { ended = number; }

int main(int count, char **given) {
    long cycle = atol(given[1]), ticks = 0;
    struct sched_param priority = {.sched_priority = atoi(given[2])};
    struct sigaction on_end = {.sa_handler = end};
    struct timespec due, now;
    sched_setscheduler(0, SCHED_FIFO, &priority);
    mlockall(MCL_CURRENT | MCL_FUTURE);
    sigaction(SIGTERM, &on_end, 0);
    clock_gettime(CLOCK_MONOTONIC, &due);
    while (!ended && ticks < %d) {
        due.tv_nsec += cycle;
        if (due.tv_nsec >= 1000000000L) { due.tv_nsec -= 1000000000L; due.tv_sec++; }
        if (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, 0)) continue;
        clock_gettime(CLOCK_MONOTONIC, &now);
        long behind = 1000000000L * (now.tv_sec - due.tv_sec) + now.tv_nsec - due.tv_nsec;
        late[ticks][0] = now.tv_sec + 1e-9 * now.tv_nsec;
        late[ticks++][1] = 1e-9 * behind;
        long skipped = behind / cycle * cycle;
        due.tv_sec += skipped / 1000000000L;
        due.tv_nsec += skipped %% 1000000000L;
        if (due.tv_nsec >= 1000000000L) { due.tv_nsec -= 1000000000L; due.tv_sec++; }
    }
    return fwrite(late, sizeof *late, ticks, stdout) != (size_t)ticks;
}
"""


class Floor:
    """When each tick of the bare loop ran and how late it was, (t, 2) [s]; filled when it has ended."""

    def __init__(self) -> None:
        self.ticks = np.zeros((0, 2))

    def lateness(self, begin: float, end: float) -> np.ndarray:
        """Of each tick between two times of the monotonic clock, shape (t,) [s]."""
        now, late = self.ticks.T
        return late[(now >= begin) & (now <= end)]


@contextmanager
def floor(cycle: float) -> Iterator[Floor]:
    """A loop that does nothing, in real time, beside what goes on in the block.

    Its lateness is that of ours: from the deadline of the tick until the program runs; like ours it skips
    what it has slept through. On the processor that it shares with our loop its priority is one above, so
    that it never waits for what our loop does and shows the machine alone. Our loop waits for it where both
    are due at once, for some microseconds.
    """
    command = [_compiled(), str(round(1e9 * cycle)), str(PRIORITY + 1)]
    found = Floor()
    with subprocess.Popen(command, stdout=subprocess.PIPE) as loop:
        try:
            yield found
        finally:
            loop.send_signal(signal.SIGTERM)
            assert loop.stdout is not None
            found.ticks = np.frombuffer(loop.stdout.read()).reshape(-1, 2)


@cache
def _compiled() -> str:
    """Path of the loop in C; its folder is kept until this process ends."""
    compiler = which("cc") or which("gcc")
    if compiler is None:
        raise SystemExit("the bare loop is written in C: install a compiler, cc or gcc")
    folder = Path(tempfile.mkdtemp(prefix="exidyn-floor-"))
    atexit.register(shutil.rmtree, folder)
    source, program = folder / "floor.c", folder / "floor"
    source.write_text(PROGRAM % (MOST, MOST))
    subprocess.run([compiler, "-O2", "-o", str(program), str(source)], check=True)
    return str(program)
