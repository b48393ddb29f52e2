"""The process of a controller's peer: it keeps its cycle, and is told on its input what goes wrong."""

import gc
import os
import select
import signal
import sys


def keep_cycle(fifo):
    """No garbage collection in a cycle; a real-time priority where one is given and allowed."""
    if fifo:
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(fifo))
        except (AttributeError, OSError):
            print("no real-time scheduling", flush=True)
    gc.collect()
    gc.freeze()
    gc.disable()


def ended_of(controller):
    """Whether the peer ends: on SIGTERM, or where its input does; each line there is a fault until then."""
    terminated, waiting = [], [""]
    signal.signal(signal.SIGTERM, lambda *_: terminated.append(True))

    def ended():
        if select.select([sys.stdin], [], [], 0.0)[0]:
            data = os.read(sys.stdin.fileno(), 4096).decode()
            if not data:
                return True
            *lines, waiting[0] = (waiting[0] + data).split("\n")
            for line in filter(None, lines):
                controller.fault(line.split())
        return bool(terminated)

    return ended
