"""Live view: starts the process that shows a run. That process may die; the run goes on."""

import os
import signal
import sys
from importlib.util import find_spec

from ..run.pipe.pipe_sink import PipeSink
from .targets import Address, CannotShow, Targets

__all__ = ["CannotShow", "LiveView", "Targets", "require_showable", "start_view"]

PROCESS = "exidyn.acquire.live.view_process"
FINISH = 10.0
"""How long the last frames may take to be shown [s]; there is no longer wait for a viewer that hangs."""


def start_view(targets: Targets) -> "list[LiveView]":
    """Start the view of a run, ready for its frames, and print where it is; none if there is no target.

    Raises:
        CannotShow: As `require_showable`.
        SinkFailed: A viewer or a server does not start.
    """
    require_showable(targets)
    if not targets.any:
        return []
    view = LiveView(targets)
    if view.message:
        print(view.message, file=sys.stderr)
    return [view]


def require_showable(targets: Targets) -> None:
    """Raise where it is plain that a run cannot be shown.

    Raises:
        CannotShow: The address is none, the file's folder is not there, or Rerun is not.
    """
    if targets.serve is not None:
        Address.read(targets.serve)
    if targets.save is not None and not targets.save.absolute().parent.is_dir():
        raise CannotShow(f"--save {targets.save}: there is no folder {targets.save.absolute().parent}")
    if targets.any and find_spec("rerun") is None:
        raise CannotShow(
            "live view: Rerun is not installed. Try pip install rerun-sdk, or go without the view"
        )


class LiveView(PipeSink):
    """The view of a run: a sink that drops what it is too slow for.

    Args:
        targets: Where to show it; one at least.
    """

    def __init__(self, targets: Targets) -> None:
        self._began = False
        super().__init__("live view", PROCESS, [targets.text()], lossy=True)
        self._began = True

    def close(self, patience: float = FINISH) -> None:
        """Wait until the last frames are shown; what a view that was killed has left behind ends too."""
        super().close(patience)
        for text in self._lacks():
            print(f"exidyn: warning: live view: {text}; the recording does not depend on it", file=sys.stderr)
        self._began = False
        try:
            os.killpg(self.process_id, signal.SIGTERM)
        except (ProcessLookupError, PermissionError):
            pass  # nothing is left

    def _lacks(self) -> list[str]:
        """What of the run was not shown, in words."""
        lacks = [self.failure] if self.failure and self._began else []
        if self.dropped and self._began:
            lacks.append(f"it was too slow for {self.dropped} cycles and events, which it does not show")
        return lacks
