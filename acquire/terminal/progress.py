"""Progress line of the current run in the terminal, written by a separate process."""

import sys
import time
from collections.abc import Sequence

from exidyn.quoting import one_line

from ..run.errors import CLEAR
from ..run.frames import END, EVENT, SAMPLE, STAGES, read_cycle, read_event
from ..run.pipe import PipeSink, PipeSource, SinkFailed
from ..run.player import BRAKING, HOLDING, RUNNING

PROCESS = "exidyn.acquire.terminal.progress"
FINISH = 2.0
"""Longest wait for the last line [s]: a terminal may have been stopped (Ctrl-S)."""
STEP = 0.2
"""Update period [s]; frames gather in the pipe meanwhile, which costs less than waking for each."""
SEEN = 2.0
"""Time of the run after which its remaining time is estimated [s]."""


class Progress(PipeSink):
    """Progress line of a run, written by a separate process so that the loop never waits for a terminal."""

    def __init__(self, seconds: float) -> None:
        super().__init__("progress", PROCESS, [f"{seconds:.3f}"], lossy=True)

    def close(self, patience: float = FINISH) -> None:
        """Wait until the line is removed."""
        super().close(patience)


def start_progress(seconds: float) -> list[Progress]:
    """The progress line of a motion [s] if standard error is a terminal; a run also works without it."""
    if not sys.stderr.isatty():
        return []
    try:
        return [Progress(seconds)]
    except SinkFailed:
        return []


class Line:
    """Text of the progress line of a motion of some seconds [s]."""

    def __init__(self, seconds: float) -> None:
        self._seconds, self._began, self._played = seconds, 0, 0.0
        self._stage, self._missed, self._since = 0, 0, 0.0
        self.over = False  # whether the loop has reported the end of the run

    def add(self, kind: bytes, body: bytes) -> None:
        """Update the line with one frame of the run."""
        self.over |= kind == END
        if kind != SAMPLE:
            return
        cycle = read_cycle(body)
        self._stage, self._missed = cycle.stage, self._missed + cycle.skipped
        if cycle.stage == RUNNING:
            self._began = self._began or cycle.host_time
            self._played = min(1e-9 * (cycle.host_time - self._began), self._seconds)

    def time_left(self, now: float) -> str:
        """Remaining time at the speed so far, which is not real time for a simulated arm; empty at first."""
        self._since = self._since or (now if self._played else 0.0)
        if not self._played or now - self._since < SEEN:
            return ""
        seconds = (self._seconds - self._played) * (now - self._since) / self._played
        return f"; about {seconds:.0f} s left"

    def __str__(self) -> str:
        played = f" {self._played:.1f} of {self._seconds:.1f} s" if self._began else ""
        advice = "" if self._stage in (BRAKING, HOLDING) else "; Ctrl-C stops the arm"
        return f"{STAGES[self._stage]}{played}; cycles missed: {self._missed}{advice}"


def stop_line(kind: bytes, body: bytes) -> str:
    """The line that reports a requested stop and its reason at once; empty for all other frames."""
    event = read_event(body) if kind == EVENT else None
    if event is None or event.kind != "stop":
        return ""
    return f"{CLEAR}{one_line(str(event.details.get('level', 'stop')))}: {one_line(event.text)}\n"


def main(arguments: Sequence[str]) -> None:
    """Write the line until the run is over, then remove it."""
    source = PipeSource(arguments)
    source.ready()
    line = Line(float(source.arguments[0]))
    while not source.ended and not line.over:
        for kind, body in source.read(1.0):
            line.add(kind, body)
            _write(stop_line(kind, body))
        _write(f"{CLEAR}{line}{line.time_left(time.monotonic())}")
        time.sleep(STEP)
    _write(CLEAR)
    source.done("shown")


def _write(text: str) -> None:
    try:
        sys.stderr.write(text)
        sys.stderr.flush()
    except OSError:
        pass  # the terminal has gone; the run has not


if __name__ == "__main__":
    main(sys.argv[1:])
