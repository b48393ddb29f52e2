"""Progress: a line in the terminal about the run that goes on."""

import sys

from ..run.pipe.pipe_sink import PipeSink, SinkFailed

PROCESS = "exidyn.acquire.terminal.progress_process"
FINISH = 2.0
"""How long the last line may take [s]; there is no longer wait for a terminal that was stopped (Ctrl-S)."""


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
