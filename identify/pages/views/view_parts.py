"""What every view in Rerun shares: its time line, its colours, and how its viewer is opened."""

import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import rerun as rr

TIMELINE = "time"
JOINTS = ((86, 180, 233), (230, 159, 0), (0, 158, 115), (240, 228, 66), (204, 121, 167), (70, 110, 255))
"""Colours that colour-blind readers, too, can distinguish as thin lines; a seventh joint is white."""
GREY = (140, 140, 140)
"""Of what no joint moves, seen on dark ground and on light."""
WHITE = (240, 240, 240)


def send(recording: rr.RecordingStream, entity: str, time: np.ndarray, values: np.ndarray) -> None:
    """All samples of an entity at once, values (r,) or (r, n)."""
    index = rr.TimeColumn(TIMELINE, duration=time)
    recording.send_columns(entity, indexes=[index], columns=rr.Scalars.columns(scalars=values))


def open_viewer(save: Callable[[Path], None], name: str) -> "subprocess.Popen[bytes]":
    """Show in Rerun's viewer, which lives on after this process, what `save` writes.

    The viewer gets a file in the temporary folder rather than a stream, and listens on this machine
    only: by default it would take data from anyone on the network.
    """
    path = Path(tempfile.mkdtemp(prefix="exidyn_")) / f"{name}.rrd"
    save(path)
    return subprocess.Popen([sys.executable, "-m", "rerun", "--bind", "127.0.0.1", str(path)])
