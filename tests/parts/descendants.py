"""All processes that a command has started, by a mark in their environment: orphans, too."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4

ROOT = Path(__file__).parents[2]
MARK = "EXIDYN_TEST_MARK"


class Started:
    """A command that runs."""

    def __init__(self, process: subprocess.Popen, mark: str) -> None:
        self.process, self._mark = process, f"{MARK}={mark}".encode()

    def alive(self) -> list[int]:
        """Numbers of all processes of it that have not ended; zombies have."""
        found = []
        for folder in Path("/proc").glob("[0-9]*"):
            with suppress(OSError):
                if self._mark in (folder / "environ").read_bytes().split(b"\0"):
                    found.append(int(folder.name))
        return found


@contextmanager
def started(command: list[str], **environment: str) -> Iterator[Started]:
    """Run `python COMMAND`, and end all of it at the end."""
    mark = uuid4().hex
    process = subprocess.Popen(
        [sys.executable, *command],
        cwd=ROOT,
        env={**os.environ, **environment, MARK: mark},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
        # Whoever runs the tests under nohup ignores it, and a child would do so as well.
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),
    )
    run = Started(process, mark)
    try:
        yield run
    finally:
        for number in run.alive():
            with suppress(ProcessLookupError):
                os.kill(number, 9)
        process.wait()
        process.stderr.close()


def within(seconds: float, true: Callable[[], bool]) -> bool:
    """Whether something becomes true in time."""
    deadline = time.monotonic() + seconds
    while not (answer := true()) and time.monotonic() < deadline:
        time.sleep(0.05)
    return answer
