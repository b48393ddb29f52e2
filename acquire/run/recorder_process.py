"""The process that writes a run to a file; frames handed over are kept even if the loop dies."""

import json
import os
import struct
import sys
import time
from array import array
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, cast

import numpy as np

from .frames import END, EVENT, HEAD, SAMPLE, Cycle, Event, read_cycle, read_event
from .pipe import PipeSource
from .recorder import RunHead, part_of
from .run_file import DiskFile, RunFile

FLUSH = 0.1
"""Time between writes to the file [s]: the most that is lost if this process and the loop crash."""
NICE = -10
"""Niceness of this process, which is busy for five of every hundred milliseconds."""
ABANDONED = "the program that moved the arm ended without a reason; all samples that it handed over are here"


@dataclass
class Course:
    """State of the run so far."""

    cycles: int = 0  # number of samples
    skipped: int = 0  # number of missed cycles
    lateness: array = field(default_factory=lambda: array("d"))  # lateness of each sample [s]
    host_time: int = 0  # host's clock at the last sample [ns since 1970]
    controller_time: int = 0  # controller's clock at the last sample [ns]
    end: dict[str, Any] | None = None  # result of the loop; None until its end
    unreadable: int = 0  # number of frames that could not be read

    def count(self, cycle: Cycle) -> None:
        """Add a cycle."""
        self.cycles += 1
        self.skipped += cycle.skipped
        self.lateness.append(cycle.lateness)
        self.host_time, self.controller_time = cycle.host_time, cycle.controller_time

    def event(self, kind: str, text: str) -> Event:
        """A message of this process as an event at the time of the last cycle."""
        return Event(self.host_time, self.controller_time, kind, text, {})

    def outcome(self) -> dict[str, str]:
        """Outcome of the run, for the recording."""
        facts = {name: str(value) for name, value in (self.end or {"stop": "unknown"}).items()}
        late = np.frombuffer(self.lateness) if self.cycles else np.zeros(1)
        p50, p99 = np.percentile(late, [50, 99])
        counted = {"cycles": self.cycles, "skipped": self.skipped, "unreadable_frames": self.unreadable}
        measured = {"lateness_p50": p50, "lateness_p99": p99, "lateness_max": late.max()}
        return (
            facts
            | {name: str(number) for name, number in counted.items()}
            | {f"{name}_s": f"{value:.6f}" for name, value in measured.items()}
        )


class Recorder:
    """Writes the frames of one run from a pipe to a file."""

    def __init__(self, source: PipeSource, file: DiskFile) -> None:
        self._source, self._file = source, file
        self._run: RunFile | None = None
        self._cycles: list[Cycle] = []
        self._events: list[Event] = []
        self._warnings: list[str] = []
        self._full = ""
        self.course = Course()

    def record(self) -> bool:
        """Write until the run has ended; return whether there was a run.

        Raises:
            OSError: If the file can no longer be written.
        """
        while True:
            began = time.monotonic()
            self._take(1.0)
            self._write()
            if self._source.ended or self.course.end is not None:
                break
            # Frames that come meanwhile are read at once, which costs less than waking for each.
            time.sleep(max(began + FLUSH - time.monotonic(), 0.0))
        if self._run is None:
            return False
        if self.course.end is None and not self._source.broken:
            self._events.append(self.course.event("recorder", ABANDONED))
        self._write()
        self._run.finish(self.course.outcome())
        return True

    def _take(self, patience: float) -> None:
        """Read the available frames, and count those that cannot be read."""
        for kind, body in self._source.read(patience):
            try:
                self._add(kind, body)
            except (ArithmeticError, LookupError, TypeError, ValueError, struct.error) as error:
                self._refuse(str(error))
        if self._source.broken:
            self._refuse(self._source.broken)

    def _refuse(self, reason: str) -> None:
        self.course.unreadable += 1
        if self.course.unreadable == 1:
            self._warning(f"a frame could not be read: {reason}")

    def _warning(self, text: str) -> None:
        """Report a warning to the loop, and write it to the recording as an event."""
        self._source.fail(text)
        self._warnings.append(text)

    def _add(self, kind: bytes, body: bytes) -> None:
        if self._run is None:
            if kind != HEAD:
                raise ValueError("the first frame is not a head")
            head = RunHead.read(body)
            self._run = RunFile(cast(IO[bytes], self._file), head)
            self.course.host_time, self.course.controller_time = head.epoch, head.zero
        elif kind == SAMPLE:
            self._cycles.append(self._run.validated(read_cycle(body)))
            self.course.count(self._cycles[-1])
        elif kind == EVENT:
            self._events.append(read_event(body))
        elif kind == END:
            self.course.end = dict(json.loads(body))
        else:
            raise ValueError("a second head")

    def _write(self) -> None:
        if self._run is not None:
            warnings = [self.course.event("warning", text) for text in self._warnings]
            self._run.write(self._cycles, [*self._events, *warnings])
            self._cycles, self._events, self._warnings = [], [], []
        if self._file.full and not self._full:
            self._full = self._file.full
            self._warning(f"disk error: {self._full}")


def main(arguments: list[str]) -> None:
    """Write frames to a file, and give it its final name when it is complete."""
    source = PipeSource(arguments)
    _raise_priority()
    path = Path(source.arguments[0])
    part = part_of(path)
    try:
        with DiskFile(part) as file:
            source.ready(str(part))
            recorder = Recorder(source, file)
            recorded = recorder.record()
        _finish_file(part, path, recorded)
        source.done(f"{recorder.course.cycles} cycles in {path}" if recorded else "nothing was recorded")
    except OSError as error:
        source.fail(f"{error.filename or part}: {error.strerror or error}")
        source.done(f"what was written is in {part}")


def _raise_priority() -> None:
    """Raise the priority of this process, if allowed, so that frames do not pile up in the pipe."""
    try:
        os.setpriority(os.PRIO_PROCESS, 0, NICE)
    except OSError:
        pass


def _finish_file(part: Path, path: Path, recorded: bool) -> None:
    if not recorded:
        part.unlink()
        return
    try:
        os.link(part, path)  # unlike a rename, this fails if the path exists by now
        part.unlink()
    except FileExistsError:
        raise
    except OSError:  # a file system without hard links
        if path.exists():
            raise
        part.rename(path)


if __name__ == "__main__":
    main(sys.argv[1:])
