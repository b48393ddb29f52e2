"""Live view: starts the process that shows a run. That process may die; the run goes on."""

import os
import signal
import sys

from ..run.pipe_sink import PipeSink
from .targets import Address, CannotShow, Targets

__all__ = ["CannotShow", "LiveView", "Targets", "start_view"]

PROCESS = "exidyn.acquire.live.view_process"
FINISH = 10.0
"""How long the last frames may take to be shown [s]; nobody waits longer for a viewer that hangs."""


def start_view(targets: Targets) -> "list[LiveView]":
    """Start the view of a run, ready for its frames, and say where it is; none if there is no target.

    Raises:
        CannotShow: The address is none, or the file's folder is not there.
        SinkFailed: A viewer or a server does not start.
    """
    if targets.serve is not None:
        Address.read(targets.serve)
    if targets.save is not None and not targets.save.absolute().parent.is_dir():
        raise CannotShow(f"--save {targets.save}: there is no folder {targets.save.absolute().parent}")
    if not targets.any:
        return []
    view = LiveView(targets)
    if view.said:
        print(view.said, file=sys.stderr)
    return [view]


class LiveView(PipeSink):
    """The view of a run: a sink that drops what it is too slow for.

    Args:
        targets: Where to show it; one at least.
    """

    def __init__(self, targets: Targets) -> None:
        super().__init__("live view", PROCESS, [targets.text()], lossy=True)

    def close(self, patience: float = FINISH) -> None:
        """Wait until the last frames are shown; what a view that was killed has left behind ends too."""
        super().close(patience)
        try:
            os.killpg(self.process_id, signal.SIGTERM)
        except (ProcessLookupError, PermissionError):
            pass  # nothing is left
