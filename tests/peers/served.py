"""The process of a controller's peer: it keeps its cycle, and is told on its input what goes wrong."""

import gc
import os
import select
import signal
import sys

from virtual_clock import of_this_peer

from exidyn.drivers.host_clock import HOST


def schedule(priority=70):
    """First-in first-out scheduling, where it is allowed and the clock is that of the host."""
    if priority and of_this_peer() is HOST:
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        except (AttributeError, OSError):
            print("no real-time scheduling", flush=True)


def keep_cycle(fifo):
    """No garbage collection in a cycle; a real-time priority where one is given and allowed."""
    schedule(fifo)
    gc.collect()
    gc.freeze()
    gc.disable()


def ended_of(told):
    """Whether the peer ends: on SIGTERM, or where its input does; the words of each line there are told."""
    terminated, waiting = [], [""]
    signal.signal(signal.SIGTERM, lambda *_: terminated.append(True))

    def ended():
        if select.select([sys.stdin], [], [], 0.0)[0]:
            data = os.read(sys.stdin.fileno(), 4096).decode()
            if not data:
                return True
            *lines, waiting[0] = (waiting[0] + data).split("\n")
            for line in filter(None, lines):
                told(line.split())
        return bool(terminated)

    return ended
