"""Which processor does what while a driver is measured.

The loop has one processor, and the floor the same: both then meet the same interrupts and neighbours. Peer
and recorder have the other processors: a controller is not on the loop's computer at all, and the system
would put the recorder there too. Where there is only one processor, or where processes cannot be bound to
one, all share what there is.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress

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
