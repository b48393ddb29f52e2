"""A pipe to a process that is handed every frame of a run: the control loop's end and that of the process."""

import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from typing import Protocol

from .errors import RunError
from .frames import SAMPLE, Unframed

HELD = 1 << 20
"""Bytes that wait for a slow reader before the sink fails: five seconds of six joints at 500 Hz, in the
pipe where the operating system makes it that large, and else in memory."""
START = 60.0
"""How long a process may take to be ready [s]: one or two, but for a loaded machine with a cold disk."""
FINISH = 60.0
"""How long a process may take to finish when it has got everything [s]."""
READY, FAILURE, DONE = "ready", "failure", "done"
"""What a process reports, each in a line with some text behind it: at its start, when its work can no longer
be trusted, and at its end."""
PIECE = 1 << 16
"""Bytes that are read at once."""


class SinkFailed(RunError):
    """A process that should record or show a run does not start."""


class Sink(Protocol):
    """The recorder, the live view; `put` is called from the control loop, never blocks and never raises."""

    @property
    def failure(self) -> str:
        """Why nothing can be handed over any more; empty while it can. A run without recorder is stopped."""

    def put(self, frame: bytes) -> None:
        """Hand a frame over."""

    def close(self) -> None:
        """Wait until all is written or shown."""


class Nobody:
    """A sink without a process: in place of a recorder that is not wanted, or of a sink that has failed."""

    def __init__(self, failure: str = "") -> None:
        self.failure = failure

    def put(self, frame: bytes) -> None:
        """Drop it."""

    def close(self) -> None:
        """Nothing waits."""


class PipeSink:
    """A sink that hands frames to a process of its own. A context manager that closes it.

    The process is in a session of its own, so that Ctrl-C in a terminal does not reach it, and is scheduled
    as usual even where the loop is not. It outlives the loop's process, and has all that was handed over.

    Args:
        name: What the process is called in errors.
        module: What it runs; it opens its end as a `PipeSource`.
        arguments: Handed to it.
        lossy: Drop samples that it is too slow for, instead of keeping them and failing.
        waits: Wait for it instead: for a loop that is not in real time.
        patience: How long it may take to be ready [s].

    Attributes:
        failure: Why the run is no longer recorded or shown; empty while it is.
        dropped: Frames that it was too slow for.

    Raises:
        SinkFailed: It is not ready in time, or reports why it cannot be.
    """

    def __init__(
        self,
        name: str,
        module: str,
        arguments: Sequence[str] = (),
        lossy: bool = False,
        waits: bool = False,
        patience: float = START,
    ) -> None:
        self.name, self.dropped, self.message, self.outcome = name, 0, "", ""
        self._lossy, self._waits = lossy, waits
        self.failure = ""
        self._waiting = bytearray()
        self._received = bytearray()
        self._start(module, arguments)
        if not self._listen(patience, until=READY):
            why = self.failure or f"is not ready after {patience:g} s"
            self.close(patience=0.0)
            raise SinkFailed(f"{name}: {why}")

    def _start(self, module: str, arguments: Sequence[str]) -> None:
        frames, self._pipe = os.pipe()
        self._report, report = os.pipe()
        os.set_blocking(self._pipe, False)
        os.set_blocking(self._report, False)
        self._room = HELD - _enlarge(self._pipe)
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-m", module, str(frames), str(report), *arguments],
                pass_fds=(frames, report),
                stdin=subprocess.DEVNULL,
                start_new_session=True,
            )
        finally:
            os.close(frames)
            os.close(report)
        _schedule_as_usual(self._process.pid)

    @property
    def process_id(self) -> int:
        """Of the process."""
        return self._process.pid

    def put(self, frame: bytes) -> None:
        """Hand a frame over; never raises, nor blocks unless it `waits`. After a failure it still tries."""
        if self._pipe < 0:
            return
        self._waiting += frame
        self._drain()
        if self._waits and self._waiting and not self.failure:
            self._wait_for_room(FINISH)
        if self._lossy:
            self._drop(frame)
        elif len(self._waiting) > self._room:
            self._fail(f"has been too slow, {len(self._waiting)} bytes wait for it")
        self._listen(0.0)

    def _drop(self, frame: bytes) -> None:
        """Take the last frame back if none of it has gone out; what is not a sample may wait a while."""
        spared = frame[:1] != SAMPLE and len(self._waiting) <= HELD
        if len(self._waiting) >= len(frame) and not spared:
            del self._waiting[-len(frame) :]
            self.dropped += 1

    def _drain(self) -> None:
        try:
            while self._waiting:
                del self._waiting[: os.write(self._pipe, self._waiting)]
        except BlockingIOError:
            pass
        except OSError:  # the process is gone; its last message is read next
            self._waiting.clear()

    def _listen(self, patience: float, until: str = "") -> bool:
        """Take in what the process reports; whether `until` was among it, or its end where that is empty."""
        deadline = time.monotonic() + patience
        while True:
            try:
                data = os.read(self._report, 4096)
            except BlockingIOError:
                left = deadline - time.monotonic()
                if left <= 0.0:
                    return False
                select.select([self._report], [], [], left)
                continue
            if not data:
                if self._pipe >= 0:  # it has ended without being asked to
                    self._fail(self.outcome or "its process has ended without a word")
                return not until
            self._received += data
            if self._take_in() == until and until:
                return True

    def _take_in(self) -> str:
        """Take in whole lines; the kind of the last one."""
        *lines, rest = bytes(self._received).split(b"\n")
        self._received[:] = rest
        kind = ""
        for line in lines:
            kind, _, text = line.decode(errors="replace").partition(" ")
            if kind == FAILURE:
                self._fail(text)
            elif kind == DONE:
                self.outcome = text
            else:
                self.message = text
        return kind

    def _fail(self, why: str) -> None:
        self.failure = self.failure or why

    def _wait_for_room(self, patience: float) -> None:
        """Until nothing waits any more, or that takes too long."""
        deadline = time.monotonic() + patience
        while self._waiting and time.monotonic() < deadline:
            select.select([], [self._pipe], [], 0.1)
            self._drain()

    def close(self, patience: float = FINISH) -> None:
        """Hand over what waits, and wait until the process has done its work, at most for so long [s]."""
        if self._report < 0:
            return
        deadline = time.monotonic() + patience
        self._wait_for_room(patience)
        os.close(self._pipe)
        self._pipe = -1
        self._listen(max(deadline - time.monotonic(), 0.0))
        self._wait_for_end(max(deadline - time.monotonic(), 0.0))
        os.close(self._report)
        self._report = -1

    def _wait_for_end(self, patience: float) -> None:
        try:
            code = self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
            self._fail("has not finished in time, and was killed")
            return
        if code:
            how = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code}"
            self._fail(f"its process {how}")

    def __enter__(self) -> "PipeSink":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _enlarge(pipe: int) -> int:
    """Make a pipe as large as is allowed, up to `HELD`; its size."""
    try:
        import fcntl  # Windows has none, and lists the commands all the same

        return fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, HELD)
    except (ImportError, AttributeError, OSError):  # not Linux, or a user with too many large pipes
        return select.PIPE_BUF


def _schedule_as_usual(process: int) -> None:
    try:
        os.sched_setscheduler(process, os.SCHED_OTHER, os.sched_param(0))
    except (AttributeError, OSError):
        pass  # it has ended already, or the operating system has no such thing


class PipeSource:
    """Gives the frames of a run to the process that a `PipeSink` started, and reports to that.

    Signals that ask to end are ignored from here on: the process ends when the run does.

    Args:
        arguments: Arguments of the process: two file numbers, then what `PipeSink` was given.

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
        """Kind and body of the frames that are there, in order; waits for the first, at most so long [s]."""
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
