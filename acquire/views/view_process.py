"""The process that shows a run: it reads frames from a pipe and logs them to Rerun in batches.

Everything that could delay a control loop happens here: Rerun holds the interpreter for milliseconds, and
waits for a viewer that does not keep up.
"""

import json
import struct
import sys
import time
from collections.abc import Callable, Sequence
from typing import Protocol

import rerun as rr

from ..run.frames import END, EVENT, HEAD, SAMPLE, Cycle, Event, read_cycle, read_event
from ..run.pipe import PipeSource
from ..run.recorder import RunHead
from . import viewers
from .live_log import LiveLog
from .live_view import CannotShow, Targets

BATCH = 0.05
"""Time over which frames are collected [s]: the cost is per batch, and the eye sees no difference."""
PAGE_BATCH = 0.1
"""This time if pages are served: a browser handles a limited number of messages per frame."""
MIN_CYCLES = 20
"""Number of first cycles that determine the cycle time; a shorter run is shown when it ends."""
ABANDONED = "the program that moves the arm ended without a reason"
PATIENCE = 5.0
"""Maximum time for a viewer to receive the last frames [s]."""
LAST_PAGE = 1.0
"""Time after the end for which a server still sends to its pages [s]; they keep what they have received."""


class Frames(Protocol):
    """Takes frames and draws them in batches; the last batch is drawn when they have ended."""

    def take(self, kind: bytes, body: bytes) -> None:
        """Take a frame."""

    def draw(self, last: bool) -> None:
        """Draw what was taken since the last batch."""


def show_frames(arguments: Sequence[str], make: Callable[[rr.RecordingStream], Frames]) -> int:
    """Show frames until they end; return the exit code."""
    source = PipeSource(arguments)
    targets = Targets.read(source.arguments[0])
    try:
        recording, message = _start(targets)
    except CannotShow as error:
        source.fail(str(error))
        viewers.end_servers()
        return 1
    _warm_up()
    source.ready(message)
    _show(source, make(recording), BATCH if targets.serve is None else PAGE_BATCH)
    _finish(recording)
    if targets.serve is not None:
        time.sleep(LAST_PAGE)
    source.done("shown")
    viewers.end_servers()
    return 0


def _start(targets: Targets) -> tuple[rr.RecordingStream, str]:
    """A recording that goes to all targets, and a message with its address; raises `CannotShow`."""
    try:
        opened = viewers.open_targets(targets)
    except OSError as error:
        raise CannotShow(f"--save {targets.save}: {error.strerror}") from error
    recording = rr.RecordingStream("exidyn_live")
    recording.set_sinks(*opened.sinks)
    return recording, f"live view: {opened.page}" if opened.page else ""


def _warm_up() -> None:
    """Log once to memory, since the first time takes a second for imports."""
    recording = rr.RecordingStream("exidyn_warm_up")
    memory = recording.memory_recording()
    index = rr.TimeColumn("time", duration=[0.0])
    recording.send_columns("nothing", indexes=[index], columns=rr.Scalars.columns(scalars=[0.0]))
    recording.log("nothing", rr.TextLog("nothing"))
    memory.drain_as_bytes()
    recording.disconnect()


def _show(source: PipeSource, frames: Frames, batch: float) -> None:
    """Show frames until they end, in batches collected over some time [s]."""
    while not source.ended:
        begun = time.monotonic()
        for kind, body in source.read(1.0):
            try:
                frames.take(kind, body)
            except (ArithmeticError, LookupError, TypeError, ValueError, struct.error):
                pass  # a frame that cannot be read, which the recorder reports
        frames.draw(source.ended)
        if not source.ended:
            time.sleep(max(begun + batch - time.monotonic(), 0.0))


class RunFrames:
    """Logs the frames of a run in batches."""

    def __init__(self, recording: rr.RecordingStream) -> None:
        self._recording = recording
        self._head: RunHead | None = None
        self._log: LiveLog | None = None
        self._cycles: list[Cycle] = []
        self._events: list[Event] = []
        self._times = 0, 0
        self._over = False

    def draw(self, last: bool) -> None:
        """Log what was taken since the last batch."""
        if last and not self._over:
            self._report("stop", ABANDONED)
        if self._log is None:
            if self._head is None or len(self._cycles) < (1 if last else MIN_CYCLES):
                return
            self._log = LiveLog(self._recording, self._head, self._cycles)
        if self._cycles:
            self._log.cycles(self._cycles)
        for event in self._events:
            self._log.event(event)
        self._cycles, self._events = [], []

    def take(self, kind: bytes, body: bytes) -> None:
        """Take a frame."""
        if kind == HEAD:
            self._head = self._head or RunHead.read(body)
        elif kind == SAMPLE:
            cycle = read_cycle(body)
            if self._head is None or cycle.arrays.shape[1] != self._head.model.robot.dof:
                raise ValueError(f"a sample of {cycle.arrays.shape[1]} joints")
            self._times = cycle.host_time, cycle.controller_time
            self._cycles.append(cycle)
        elif kind == EVENT:
            self._events.append(read_event(body))
        elif kind == END:
            self._over = True
            end = json.loads(body)
            # the reason of a stop was reported when it happened
            stopped = end.get("stop", "none") != "none"
            self._report("end", f"stopped ({end['stop']})" if stopped else str(end.get("text", "")))

    def _report(self, kind: str, text: str) -> None:
        self._events.append(Event(*self._times, kind, text, {}))


def _finish(recording: rr.RecordingStream) -> None:
    """Send the last data and write the footer of a file; a closed viewer is not an error."""
    try:
        recording.flush(timeout_sec=PATIENCE)
    except Exception:  # Rerun has already printed its error
        pass
    recording.disconnect()


if __name__ == "__main__":
    sys.exit(show_frames(sys.argv[1:], RunFrames))
