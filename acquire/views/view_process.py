"""The process that shows a run: frames in from a pipe, logged to Rerun in batches.

Everything that could hold a control loop up happens here: Rerun holds the interpreter for milliseconds, and
waits for a viewer that does not keep up.
"""

import json
import struct
import sys
import time
from collections.abc import Sequence

import rerun as rr

from ..run.frames import END, EVENT, HEAD, SAMPLE, Cycle, Event, read_cycle, read_event
from ..run.pipe import PipeSource
from ..run.recorder import RunHead
from . import viewers
from .live_log import LiveLog
from .live_view import CannotShow, Targets

BATCH = 0.05
"""How long frames are gathered [s]: the cost is by the batch, and the eye sees no difference."""
PAGE_BATCH = 0.1
"""The same where pages are served: a browser takes in only so many messages a picture."""
FEWEST = 20
"""Cycles that are waited for at first, to learn how long one is; a run that ends before is shown as it is."""
ABANDONED = "the program that moves the arm has ended without a word"
PATIENCE = 5.0
"""How long a viewer may take for the last frames [s]."""
LAST_PAGE = 1.0
"""How long after the end a server still sends to its pages [s]; they keep what they have got."""


def main(arguments: Sequence[str]) -> int:
    """Show a run until its frames end; the exit code."""
    source = PipeSource(arguments)
    targets = Targets.read(source.arguments[0])
    try:
        recording, where = _start(targets)
    except CannotShow as error:
        source.fail(str(error))
        viewers.end_servers()
        return 1
    _warm_up()
    source.ready(where)
    _View(recording, BATCH if targets.serve is None else PAGE_BATCH).show(source)
    _finish(recording)
    if targets.serve is not None:
        time.sleep(LAST_PAGE)
    source.done("shown")
    viewers.end_servers()
    return 0


def _start(targets: Targets) -> tuple[rr.RecordingStream, str]:
    """A recording that goes to all targets, and in words where it is seen; raises `CannotShow`."""
    try:
        opened = viewers.open_targets(targets)
    except OSError as error:
        raise CannotShow(f"--save {targets.save}: {error.strerror}") from error
    recording = rr.RecordingStream("exidyn_live")
    recording.set_sinks(*opened.sinks)
    return recording, f"live view: {opened.page}" if opened.page else ""


def _warm_up() -> None:
    """Log once unseen: the first time takes a second of imports."""
    recording = rr.RecordingStream("exidyn_warm_up")
    memory = recording.memory_recording()
    index = rr.TimeColumn("time", duration=[0.0])
    recording.send_columns("nothing", indexes=[index], columns=rr.Scalars.columns(scalars=[0.0]))
    recording.log("nothing", rr.TextLog("nothing"))
    memory.drain_as_bytes()
    recording.disconnect()


class _View:
    """What has come so far; shown in batches of some time [s]."""

    def __init__(self, recording: rr.RecordingStream, batch: float = BATCH) -> None:
        self._recording, self._batch = recording, batch
        self._head: RunHead | None = None
        self._log: LiveLog | None = None
        self._cycles: list[Cycle] = []
        self._events: list[Event] = []
        self._times = 0, 0
        self._over = False

    def show(self, source: PipeSource) -> None:
        """Show frames until they end."""
        while not source.ended:
            begun = time.monotonic()
            for kind, body in source.read(1.0):
                try:
                    self._take(kind, body)
                except (ArithmeticError, LookupError, TypeError, ValueError, struct.error):
                    pass  # a frame that makes no sense, which the recorder reports
            if source.ended and not self._over:
                self._report("stop", ABANDONED)
            self._log_batch(source.ended)
            if not source.ended:
                time.sleep(max(begun + self._batch - time.monotonic(), 0.0))

    def _take(self, kind: bytes, body: bytes) -> None:
        if kind == HEAD:
            self._head = self._head or RunHead.read(body)
        elif kind == SAMPLE:
            self._take_cycle(read_cycle(body))
        elif kind == EVENT:
            self._events.append(read_event(body))
        elif kind == END:
            self._over = True
            end = json.loads(body)
            # why it was stopped was reported when it happened
            early = end.get("stop", "none") != "none"
            self._report("end", f"stopped ({end['stop']})" if early else str(end.get("text", "")))

    def _take_cycle(self, cycle: Cycle) -> None:
        if self._head is None or cycle.arrays.shape[1] != self._head.model.robot.dof:
            raise ValueError(f"a sample of {cycle.arrays.shape[1]} joints")
        self._times = cycle.host_time, cycle.controller_time
        self._cycles.append(cycle)

    def _report(self, kind: str, text: str) -> None:
        self._events.append(Event(*self._times, kind, text, {}))

    def _log_batch(self, last: bool) -> None:
        if self._log is None:
            if self._head is None or len(self._cycles) < (1 if last else FEWEST):
                return
            self._log = LiveLog(self._recording, self._head, self._cycles)
        if self._cycles:
            self._log.cycles(self._cycles)
        for event in self._events:
            self._log.event(event)
        self._cycles, self._events = [], []


def _finish(recording: rr.RecordingStream) -> None:
    """Hand the last over, and write what a file ends with; a viewer that is gone is no matter."""
    try:
        recording.flush(timeout_sec=PATIENCE)
    except Exception:  # one of Rerun's own, which it has already written to the terminal
        pass
    recording.disconnect()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
