"""A pipe that carries the frames of a run from the control loop to a process: both of its ends."""

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

BUFFER = 1 << 20
"""Bytes buffered for a slow reader before the sink fails: five seconds of six joints at 500 Hz, in the
pipe as far as the operating system allows, otherwise in memory."""
START = 60.0
"""Maximum time until a process is ready [s]; it takes one or two unless the machine is loaded."""
FINISH = 60.0
"""Maximum time for a process to finish after the last frame [s]."""
READY, FAILURE, DONE = "ready", "failure", "done"
"""Reports of a process, each a line with a text: at its start, when its work can no longer be trusted, and at
its end."""
READ_SIZE = 1 << 16
"""Maximum number of bytes per read."""


class SinkFailed(RunError):
    """The process that records or shows a run does not start."""


class Sink(Protocol):
    """Receiver of frames, such as the recorder: `put`, called by the control loop, never blocks or raises."""

    @property
    def failure(self) -> str:
        """Why frames can no longer be handed over; empty while they can. A failed recorder stops the run."""

    def put(self, frame: bytes) -> None:
        """Hand over a frame."""

    def close(self) -> None:
        """Wait until all frames are written or shown."""


class Nobody:
    """A sink that drops all frames: for runs without a recorder, and for sinks that have failed."""

    def __init__(self, failure: str = "") -> None:
        self.failure = failure

    def put(self, frame: bytes) -> None:
        """Drop the frame."""

    def close(self) -> None:
        """Do nothing, since no frame is buffered."""


class PipeSink:
    """A sink that hands frames to a process that it starts; a context manager that closes the sink.

    The process has its own session, so that Ctrl-C in a terminal does not reach it. Its scheduling is normal,
    even if that of the loop is real-time. If the loop's process dies, it still has all frames handed over.

    Args:
        name: Name of the process in errors.
        module: Module that the process runs; it opens its end of the pipe as a `PipeSource`.
        arguments: Arguments of the process.
        lossy: Whether to drop samples if the process is too slow, instead of buffering them and failing.
        waits: Whether to wait if the process is too slow; for a loop that is not in real time.
        patience: Maximum time until the process is ready [s].

    Raises:
        SinkFailed: If the process is not ready in time or reports a failure.
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
        self.name, self.message, self.outcome = name, "", ""
        self.dropped = 0  # number of frames dropped because the process was too slow
        self._lossy, self._waits = lossy, waits
        self.failure = ""  # why the run is no longer recorded or shown; empty while it is
        self._waiting = bytearray()
        self._received = bytearray()
        self._start(module, arguments)
        if not self._listen(patience, until=READY):
            reason = self.failure or f"is not ready after {patience:g} s"
            self.close(patience=0.0)
            raise SinkFailed(f"{name}: {reason}")

    def _start(self, module: str, arguments: Sequence[str]) -> None:
        frames, self._pipe = os.pipe()
        self._report, report = os.pipe()
        os.set_blocking(self._pipe, False)
        os.set_blocking(self._report, False)
        self._room = BUFFER - _enlarge(self._pipe)
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
        """ID of the process."""
        return self._process.pid

    def put(self, frame: bytes) -> None:
        """Hand over a frame, even after a failure; blocks only if the sink `waits`, and never raises."""
        if self._pipe < 0:
            return
        self._waiting += frame
        self._drain()
        if self._waits and self._waiting and not self.failure:
            self._wait_for_room(FINISH)
        if self._lossy:
            self._drop(frame)
        elif len(self._waiting) > self._room:
            self._fail(f"is too slow: {len(self._waiting)} bytes wait for it, limit {self._room}")
        self._listen(0.0)

    def _drop(self, frame: bytes) -> None:
        """Drop the last frame unless part of it was sent; frames other than samples may be buffered."""
        spared = frame[:1] != SAMPLE and len(self._waiting) <= BUFFER
        if len(self._waiting) >= len(frame) and not spared:
            del self._waiting[-len(frame) :]
            self.dropped += 1

    def _drain(self) -> None:
        try:
            while self._waiting:
                del self._waiting[: os.write(self._pipe, self._waiting)]
        except BlockingIOError:
            pass
        except OSError:  # the process has ended; its last report is read next
            self._waiting.clear()

    def _listen(self, patience: float, until: str = "") -> bool:
        """Read reports until one of kind `until`, or all if empty; return whether this succeeded in time."""
        deadline = time.monotonic() + patience
        while True:
            try:
                data = os.read(self._report, 4096)
            except BlockingIOError:
                remaining = deadline - time.monotonic()
                if remaining <= 0.0:
                    return False
                select.select([self._report], [], [], remaining)
                continue
            if not data:
                if self._pipe >= 0:  # the process ended before the pipe was closed
                    self._fail(self.outcome or "its process ended without a report")
                return not until
            self._received += data
            if self._parse_reports() == until and until:
                return True

    def _parse_reports(self) -> str:
        """Parse all complete lines; return the kind of the last report."""
        *lines, incomplete = bytes(self._received).split(b"\n")
        self._received[:] = incomplete
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

    def _fail(self, reason: str) -> None:
        self.failure = self.failure or reason

    def _wait_for_room(self, patience: float) -> None:
        """Send buffered frames until none is left or time is up."""
        deadline = time.monotonic() + patience
        while self._waiting and time.monotonic() < deadline:
            select.select([], [self._pipe], [], 0.1)
            self._drain()

    def close(self, patience: float = FINISH) -> None:
        """Send buffered frames and wait until the process has finished, for at most `patience` [s]."""
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
            self._fail("did not finish in time and was killed")
            return
        if code:
            ending = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code}"
            self._fail(f"its process {ending}")

    def __enter__(self) -> "PipeSink":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _enlarge(pipe: int) -> int:
    """Enlarge a pipe up to `BUFFER` bytes, if allowed; return its size."""
    try:
        import fcntl  # missing on Windows, where this module is imported too

        return fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, BUFFER)
    except (ImportError, AttributeError, OSError):  # not Linux, or a user with too many large pipes
        return select.PIPE_BUF


def _schedule_as_usual(process: int) -> None:
    try:
        os.sched_setscheduler(process, os.SCHED_OTHER, os.sched_param(0))
    except (AttributeError, OSError):
        pass  # the process has ended, or the operating system has no such function


class PipeSource:
    """The end of the pipe in the process that a `PipeSink` started: reads frames and sends reports.

    It makes the process ignore signals to terminate: the process ends when the run does.

    Args:
        arguments: Arguments of the process: two file descriptors, then the arguments given to `PipeSink`.
    """

    def __init__(self, arguments: Sequence[str]) -> None:
        self._frames, self._report = int(arguments[0]), int(arguments[1])
        self.arguments = list(arguments[2:])  # those given to `PipeSink`
        self.ended = False  # whether no more frames will come
        self.broken = ""  # error message if the received bytes could not be frames
        self._unframed = Unframed()
        os.set_blocking(self._frames, False)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)

    def read(self, patience: float) -> list[tuple[bytes, bytes]]:
        """Kind and body of all available frames, in order; waits at most `patience` [s] for the first."""
        frames: list[tuple[bytes, bytes]] = []
        select.select([self._frames], [], [], patience)
        while not self.ended:
            try:
                data = os.read(self._frames, READ_SIZE)
            except BlockingIOError:
                break
            self.ended = not data
            try:
                frames.extend(self._unframed.add(data))
            except ValueError as error:  # the start of the next frame is unknown
                self.broken, self.ended = str(error), True
        return frames

    def ready(self, text: str = "") -> None:
        """Report that the process can take frames."""
        self._send(READY, text)

    def fail(self, reason: str) -> None:
        """Report that the work can no longer be trusted."""
        self._send(FAILURE, reason)

    def done(self, text: str) -> None:
        """Report the result of the work, which has ended."""
        self._send(DONE, text)

    def _send(self, kind: str, text: str) -> None:
        try:
            os.write(self._report, f"{kind} {' '.join(text.split())}\n".encode())
        except OSError:
            pass  # the process that started this one has ended
