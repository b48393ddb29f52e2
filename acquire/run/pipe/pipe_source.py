"""PipeSource: the other end of a `PipeSink`, in the process that it started."""

import os
import select
import signal
from collections.abc import Sequence

from .frames import Unframed
from .pipe_sink import DONE, FAILURE, READY

PIECE = 1 << 16
"""Bytes that are read at once."""


class PipeSource:
    """Gives the frames of a run, and reports to their sender.

    Signals that ask to end are ignored from here on: the process ends when the run does.

    Args:
        arguments: Of the process: two file numbers, then what `PipeSink` was given.

    Attributes:
        arguments: What `PipeSink` was given.
        ended: Whether nothing more will come.
        broken: Why, if what came could not be frames.
    """

    def __init__(self, arguments: Sequence[str]) -> None:
        self._frames, self._report = int(arguments[0]), int(arguments[1])
        self.arguments = list(arguments[2:])
        self.ended, self.broken = False, ""
        self._unframed = Unframed()
        os.set_blocking(self._frames, False)
        for asked in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(asked, signal.SIG_IGN)

    def read(self, patience: float) -> list[tuple[bytes, bytes]]:
        """Kind and body of the frames that are there; waits for the first.

        Args:
            patience: How long to wait [s].

        Returns:
            Frames in order; none after that time, or when there will be no more and `ended` is so.
        """
        found: list[tuple[bytes, bytes]] = []
        select.select([self._frames], [], [], patience)
        while not self.ended:
            try:
                data = os.read(self._frames, PIECE)
            except BlockingIOError:
                break
            self.ended = not data
            try:
                found.extend(self._unframed.add(data))
            except ValueError as error:  # the begin of the next frame is unknown
                self.broken, self.ended = str(error), True
        return found

    def ready(self, text: str = "") -> None:
        """Report that the process can take frames."""
        self._say(READY, text)

    def fail(self, why: str) -> None:
        """Report that the work can no longer be trusted."""
        self._say(FAILURE, why)

    def done(self, text: str) -> None:
        """Report what has become of the work, and that it is over."""
        self._say(DONE, text)

    def _say(self, kind: str, text: str) -> None:
        try:
            os.write(self._report, f"{kind} {' '.join(text.split())}\n".encode())
        except OSError:
            pass  # whoever started this process is gone
