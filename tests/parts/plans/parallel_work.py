"""What test_parallel.py has done in other processes, which must be able to import it."""

import os
import signal
import time

LONG = 300.0
"""Seconds in which every test ends; nothing waits for them unless something hangs."""


def square(number, seconds, stop):
    """With who did it."""
    return number**2, os.getpid(), os.environ.get("OMP_NUM_THREADS")


def until_asked(number, seconds, stop):
    """What a search does: goes on until it is asked to end, then reports what it has."""
    begun = time.monotonic()
    while not stop():
        if time.monotonic() - begun > LONG:
            return "hangs"
        time.sleep(0.01)
    return number


def failing(number, seconds, stop):
    """One fails at once, the others would go on."""
    if number == 1:
        raise ZeroDivisionError("one")
    return until_asked(number, seconds, stop) if number > 1 else number


def dying(number, seconds, stop):
    os._exit(3)


def told_time(number, seconds, stop):
    return seconds


def pressing(number, seconds, stop):
    """Somebody presses Ctrl-C while it works."""
    assert not stop()
    os.kill(os.getpid(), signal.SIGINT)
    return number, stop()


def pressing_twice(number, seconds, stop):
    """Somebody does not want to wait."""
    for _ in range(2):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.01)


def reporting(number, seconds, stop):
    """How far it is, before it ends."""
    from exidyn.trajectories.search.parallel import report

    report(10 * number)
    time.sleep(0.5)  # longer than it takes to be received
    return number
