"""A loaded machine, made on purpose."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

WORK = "import numpy as np\na = np.ones((200, 200))\nwhile True: a @ a"


@contextmanager
def busy(processes: int) -> Iterator[None]:
    """So many processes that compute without end, for as long as the block lasts."""
    running = [subprocess.Popen([sys.executable, "-c", WORK]) for _ in range(processes)]
    try:
        yield
    finally:
        for process in running:
            process.kill()
            process.wait()
