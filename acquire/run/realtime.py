"""What an operating system can do for a loop of two milliseconds, asked for and given back."""

import ctypes
import gc
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

PRIORITY = 80
"""Of the control thread: above the usual and above interrupt threads (50) of a real-time kernel, below its
watchdogs (99)."""
SWITCH = 5e-4
"""How long another Python thread may keep the interpreter [s]: a quarter of a cycle of 2 ms."""
LESSER = 1
"""Of a thread that computes beside the control thread: one as high would starve it on a single processor; one
scheduled as usual would be interrupted by other programs while it holds the interpreter, which the control
thread then waits for."""
_LOCK_ALL = 3  # MCL_CURRENT | MCL_FUTURE


@contextmanager
def realtime() -> Iterator[list[str]]:
    """First-in first-out scheduling, memory locked, no garbage collection; gives what was refused.

    Threads that start inside inherit the scheduling, processes too: start those that should not before.
    """
    policy, parameters, interval = _policy(), _parameters(), sys.getswitchinterval()
    refused = [text for text in (_fifo(), _lock()) if text]
    gc.collect()
    gc.freeze()
    gc.disable()
    sys.setswitchinterval(SWITCH)
    try:
        yield refused
    finally:
        sys.setswitchinterval(interval)
        gc.enable()
        gc.unfreeze()
        _give_back(policy, parameters)


def yield_to_the_loop() -> None:
    """Put the calling thread, which has inherited the control thread's scheduling, behind it."""
    if _parameters():
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(LESSER))


def _policy() -> int:
    return os.sched_getscheduler(0) if hasattr(os, "sched_getscheduler") else 0


def _parameters() -> int:
    return os.sched_getparam(0).sched_priority if hasattr(os, "sched_getparam") else 0


def _fifo() -> str:
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except (AttributeError, OSError):
        return (
            "the operating system refuses real-time scheduling: one cycle in ten may be late under load. "
            "Allow it with 'rtprio 80' in /etc/security/limits.conf, or run as root"
        )
    return ""


def _lock() -> str:
    try:
        refused = ctypes.CDLL(None, use_errno=True).mlockall(_LOCK_ALL)
    except (OSError, AttributeError):
        refused = 1
    if refused:
        return (
            "memory could not be locked, so that a cycle may wait for the disk. Allow it with "
            "'memlock unlimited' in /etc/security/limits.conf, or run as root"
        )
    return ""


def _give_back(policy: int, priority: int) -> None:
    try:
        ctypes.CDLL(None).munlockall()
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except (AttributeError, OSError):
        pass  # it could not be had in the first place
