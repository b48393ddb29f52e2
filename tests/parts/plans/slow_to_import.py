"""What test_parallel.py has done where a process takes longer to start than it has to work."""

import time
from multiprocessing import current_process

from .parallel_work import until_asked

if current_process().name != "MainProcess":
    time.sleep(1.0)


def time_until_asked(*asked):
    """How long it could work [s]."""
    begun = time.monotonic()
    until_asked(*asked)
    return time.monotonic() - begun
