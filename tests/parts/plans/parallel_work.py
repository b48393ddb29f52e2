"""What test_parallel.py has done in other processes, which must be able to import it."""

import os
import signal
import time

LONG = 300.0
"""Seconds in which every test ends; nothing waits for them unless something hangs."""


def square(number, *_):
    """With who did it."""
    return number**2, os.getpid(), os.environ.get("OMP_NUM_THREADS")


def until_asked(number, seconds, stop, report):
    """What a search does: goes on until it is asked to end, then reports what it has."""
    begun = time.monotonic()
    while not stop():
        if time.monotonic() - begun > LONG:
            return "hangs"
        time.sleep(0.01)
    return number


def waiting_from_two(number, *asked):
    """The first ends at once, the others when they are asked to."""
    return until_asked(number, *asked) if number > 1 else number


def failing(number, *asked):
    """One fails at once, the others would go on."""
    if number == 1:
        raise ZeroDivisionError("one")
    return until_asked(number, *asked)


def dying(*_):
    os._exit(3)


def pressing(number, seconds, stop, report):
    """Somebody presses Ctrl-C while it works."""
    assert not stop()
    os.kill(os.getpid(), signal.SIGINT)
    return until_asked(number, seconds, stop, report)


def pressing_twice(*asked):
    """Somebody does not want to wait."""
    pressing(*asked)
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(0.5)


def reporting(number, seconds, stop, report):
    """How far it is, before it ends."""
    report(10 * number)
    time.sleep(0.5)  # longer than it takes to be received
    return number
