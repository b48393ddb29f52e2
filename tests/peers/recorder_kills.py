"""Kill the recorder, the program that feeds it, or both, and look what is left."""

import os
import signal
import struct
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

from exidyn.acquire.run.recorder import part_of
from exidyn.identification.recordings.mcap.mcap_file import read_recording

SOURCE = Path(__file__).with_name("frame_source.py")
LONGEST = 60.0


class Left(NamedTuple):
    """What a kill left."""

    file: Path  # the recording, whole or not
    recording: object  # as it is read
    lost_ms: float  # time from the last cycle in the file to the last that had been handed over [ms]
    printed: str  # last line of the program that fed the recorder; empty if it was killed


def kill(folder: Path, victims: tuple[str, ...], after: float) -> Left:
    """Kill "recorder", "loop" or both some time after the run began [s]."""
    path, progress = folder / "run.mcap", folder / "progress"
    progress.write_bytes(bytes(16))
    command = [sys.executable, str(SOURCE), str(path), str(progress), str(LONGEST)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as loop:
        recorder = 0
        try:
            recorder = int(loop.stdout.readline().split()[1])
            time.sleep(after)
            processes = {"recorder": recorder, "loop": loop.pid}
            _, handed = _handed(progress)
            for victim in victims:
                os.kill(processes[victim], signal.SIGKILL)
            output = loop.stdout.read().strip()  # ends when both have ended
        finally:
            loop.kill()
            _kill(recorder)
    # The loop went on for a moment, until it was killed itself: what a whole recorder owes is all of it.
    begun, all_handed = _handed(progress)
    handed = handed if "recorder" in victims else all_handed
    left = path if path.exists() else part_of(path)
    recording = read_recording(left)
    last = int(recording.host_time[-1]) if len(recording.host_time) else begun
    return Left(left, recording, 1e-6 * max(handed - last, 0), output)


def _handed(progress: Path) -> tuple[int, int]:
    """Host's clock when the run began and at the last sample that was handed over [ns]."""
    begun, last = struct.unpack("<qq", progress.read_bytes())
    return begun, max(begun, last)


def _kill(process: int) -> None:
    try:
        if process:
            os.kill(process, signal.SIGKILL)
    except ProcessLookupError:
        pass
