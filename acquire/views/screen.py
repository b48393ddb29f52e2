"""Screen: where a view is shown; in a window, in browsers, or as a file for later."""

import sys
from collections.abc import Callable
from typing import NamedTuple

import rerun as rr
import rerun.blueprint as rrb

from ..live import viewers
from ..live.live_view import require_showable
from ..live.targets import CannotShow, Targets

PATIENCE = 60.0
"""How long a viewer may take to take everything in [s]."""


class View(NamedTuple):
    """What is shown.

    Attributes:
        kind: A word; viewers keep a layout by it.
        log: Writes everything to an open recording.
        blueprint: The layout.
    """

    kind: str
    log: Callable[[rr.RecordingStream], None]
    blueprint: rrb.Blueprint


def show(view: View, targets: Targets) -> None:
    """Show a view at all targets; with a server among them, until that ends or Ctrl-C.

    Raises:
        CannotShow: A target cannot be opened, or takes too long.
    """
    require_showable(targets)
    opened = viewers.open_targets(targets)
    try:
        _log(view, opened)
        if opened.server is not None:
            print(f"view: {opened.page} (Ctrl-C ends it)", file=sys.stderr, flush=True)
            opened.server.wait()
    except KeyboardInterrupt:
        pass  # that is how it ends
    finally:
        if opened.server is not None:
            opened.server.terminate()
            opened.server.wait()


def _log(view: View, opened: viewers.Opened) -> None:
    recording = rr.RecordingStream(f"exidyn_{view.kind}")
    recording.set_sinks(*opened.sinks, default_blueprint=view.blueprint)
    view.log(recording)
    try:
        recording.flush(timeout_sec=PATIENCE)
    except RuntimeError as error:
        raise CannotShow(
            f"the viewer has not taken everything within {PATIENCE:.0f} s: {error}. "
            "On a busy machine, or one without a screen, try --save FILE"
        ) from error
    recording.disconnect()  # writes the footer of a file, without which readers complain
