"""Real-time settings of the operating system for a 2 ms loop, and their restoration."""

import ctypes
import gc
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

PRIORITY = 80
"""Priority of the control thread: above normal threads and the interrupt threads (50) of a real-time kernel,
below its watchdogs (99)."""
SWITCH = 5e-4
"""Maximum time that another Python thread holds the interpreter [s]: a quarter of a 2 ms cycle."""
LESSER = 1
"""Priority of a thread that computes beside the control thread. At equal priority it would starve the control
thread on a single CPU. With normal scheduling, other programs would interrupt it while it holds the
interpreter, and the control thread would have to wait."""
_LOCK_ALL = 3  # MCL_CURRENT | MCL_FUTURE


@contextmanager
def realtime() -> Iterator[list[str]]:
    """Use FIFO scheduling, locked memory and no garbage collection; yields messages about refused settings.

    Threads and processes started inside inherit the scheduling: start others before.
    """
    policy = os.sched_getscheduler(0) if hasattr(os, "sched_getscheduler") else 0
    parameters, interval = _parameters(), sys.getswitchinterval()
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
    """Give the calling thread, which has inherited the control thread's scheduling, a lower priority."""
    if _parameters():
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(LESSER))


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
            "memory could not be locked: a cycle may have to wait for the disk. Allow it with "
            "'memlock unlimited' in /etc/security/limits.conf, or run as root"
        )
    return ""


def _give_back(policy: int, priority: int) -> None:
    try:
        ctypes.CDLL(None).munlockall()
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except (AttributeError, OSError):
        pass  # it was refused in the first place
