"""Progress: a line in the terminal about the run that goes on, written by a process of its own."""

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
"""How long the last line may take [s]; there is no longer wait for a terminal that was stopped (Ctrl-S)."""
STEP = 0.2
"""Time between looks [s]; frames gather in the pipe meanwhile, which costs less than to wake for each."""
SEEN = 2.0
"""Time of the run that foretells the rest [s]."""


class Progress(PipeSink):
    """The line of a run, written by a process of its own: the loop never waits for a terminal.

    Args:
        seconds: Duration of the motion [s].
    """

    def __init__(self, seconds: float) -> None:
        super().__init__("progress", PROCESS, [f"{seconds:.3f}"], lossy=True)

    def close(self, patience: float = FINISH) -> None:
        """Wait until the line is gone."""
        super().close(patience)


def start_progress(seconds: float) -> list[Progress]:
    """The line of a run, if a person is at the terminal; a run can do without."""
    if not sys.stderr.isatty():
        return []
    try:
        return [Progress(seconds)]
    except SinkFailed:
        return []


class Line:
    """How far a run has got.

    Args:
        seconds: Duration of the motion [s].

    Attributes:
        over: Whether the loop has reported the end.
    """

    def __init__(self, seconds: float) -> None:
        self._seconds, self._began, self._gone = seconds, 0, 0.0
        self._stage, self._missed, self._since = 0, 0, 0.0
        self.over = False

    def add(self, kind: bytes, body: bytes) -> None:
        """Take in one frame of the run."""
        self.over |= kind == END
        if kind != SAMPLE:
            return
        cycle = read_cycle(body)
        self._stage, self._missed = cycle.stage, self._missed + cycle.skipped
        if cycle.stage == RUNNING:
            self._began = self._began or cycle.host_time
            self._gone = min(1e-9 * (cycle.host_time - self._began), self._seconds)

    def left(self, now: float) -> str:
        """How long it will still take by the speed until now, which a simulated arm sets; empty at first.

        Args:
            now: On any clock that goes on evenly [s].
        """
        self._since = self._since or (now if self._gone else 0.0)
        if not self._gone or now - self._since < SEEN:
            return ""
        left = (self._seconds - self._gone) * (now - self._since) / self._gone
        return f"; about {left:.0f} s left"

    def __str__(self) -> str:
        gone = f" {self._gone:.1f} of {self._seconds:.1f} s" if self._began else ""
        advice = "" if self._stage in (BRAKING, HOLDING) else "; Ctrl-C brakes"
        return f"{STAGES[self._stage]}{gone}; cycles missed: {self._missed}{advice}"


def stop_line(kind: bytes, body: bytes) -> str:
    """What a person reads at once of a frame: that a stop was asked for, and why; empty for all else."""
    event = read_event(body) if kind == EVENT else None
    if event is None or event.kind != "stop":
        return ""
    return f"{CLEAR}{one_line(str(event.details.get('level', 'stop')))}: {one_line(event.text)}\n"


def main(arguments: Sequence[str]) -> None:
    """Write the line until the run is over, and leave none."""
    source = PipeSource(arguments)
    source.ready()
    line = Line(float(source.arguments[0]))
    while not source.ended and not line.over:
        for kind, body in source.read(1.0):
            line.add(kind, body)
            _write(stop_line(kind, body))
        _write(f"{CLEAR}{line}{line.left(time.monotonic())}")
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
