"""A 500 Hz loop that hands over frames to no one, to a thread or to a process, and how late it is."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections import deque
from dataclasses import replace
from pathlib import Path
from threading import Event, Thread
from typing import IO, Any, cast

import numpy as np
from common import imports_as_here
from frame_source import CYCLE, head, sample

from exidyn.acquire.run.frames import END, read_cycle, sample_frame, text_frame
from exidyn.acquire.run.pipe import PipeSink
from exidyn.acquire.run.realtime import realtime
from exidyn.acquire.run.recorder import RunHead, start_recorder
from exidyn.acquire.run.recorder_process import FLUSH
from exidyn.acquire.run.run_file import DiskFile, RunFile
from exidyn.drivers.host_clock import HostClock, host_time

from .busy import busy

WHO = ("none", "thread", "process")
HEAD_ROOM = 5
"""Bytes before the body of a frame."""


class NoSink:
    """Takes frames and does nothing."""

    def put(self, frame: bytes) -> None:
        pass

    def close(self) -> None:
        pass


class InThread:
    """What the recorder's process does, as a thread of the loop's process."""

    def __init__(self, path: Path) -> None:
        self._frames: deque[bytes] = deque()
        self._file = DiskFile(path)
        self._run = RunFile(cast(IO[bytes], self._file), RunHead.read(head(host_time()).frame()[HEAD_ROOM:]))
        self._closing = Event()
        self._thread = Thread(target=self._work)
        self._thread.start()

    def put(self, frame: bytes) -> None:
        self._frames.append(frame)

    def _work(self) -> None:
        while not self._closing.wait(FLUSH):
            self._write()

    def _write(self) -> None:
        bodies = [self._frames.popleft()[HEAD_ROOM:] for _ in range(len(self._frames))]
        self._run.write([read_cycle(body) for body in bodies], [])

    def close(self) -> None:
        self._closing.set()
        self._thread.join()
        self._write()
        self._run.finish({})
        self._file.close()


def sink_of(who: str, path: Path) -> NoSink | InThread | PipeSink:
    """Ready to take frames; started before the loop's scheduling, which it must not inherit."""
    if who == "process":
        sink = start_recorder(path)
        sink.put(head(host_time()).frame())
        return sink
    return InThread(path) if who == "thread" else NoSink()


def loop(who: str, seconds: float) -> dict[str, Any]:
    """Run the loop, in this process; its figures."""
    # Random numbers are made before: the loop is about handing over.
    samples = [sample(number, 0) for number in range(200)]
    late, taken, skipped = [], [], 0
    with tempfile.TemporaryDirectory() as folder:
        sink = sink_of(who, Path(folder) / "run.mcap")
        time.sleep(1.0)
        with realtime() as refused:
            clock, used = HostClock(CYCLE), cpu(sink)
            for _ in range(round(seconds / CYCLE)):
                tick = clock.wait()
                measured, command = samples[tick.number % len(samples)]
                now = host_time()
                measured = replace(measured, host_time=now, controller_time=round(tick.number * CYCLE * 1e9))
                frame = sample_frame(measured, command, 2)
                before = time.perf_counter_ns()
                sink.put(frame)
                taken.append(time.perf_counter_ns() - before)
                late.append(tick.lateness)
                skipped += tick.skipped
            used = cpu(sink) - used
        if isinstance(sink, PipeSink):
            sink.put(text_frame(END, {}))
        sink.close()
    return {
        "lateness_us": (1e6 * np.percentile(late, [50, 99, 100])).tolist(),
        "put_us": (1e-3 * np.percentile(taken, [50, 99])).tolist(),
        "skipped": skipped,
        "cpu": used / seconds,
        "real_time": not refused,
    }


def cpu(sink: NoSink | InThread | PipeSink) -> float:
    """CPU time of this process and of the one that writes [s]."""
    processes = [os.getpid()] + ([sink.process_id] if isinstance(sink, PipeSink) else [])
    times = [
        Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[11:13] for process in processes
    ]
    return sum(int(ticks) for pair in times for ticks in pair) / os.sysconf("SC_CLK_TCK")


def measured(who: str, load: int, seconds: float) -> dict[str, Any]:
    """Figures of one case."""
    with busy(load):
        command = [sys.executable, "-P", "-m", __name__, who, str(seconds)]
        output = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, env=imports_as_here())
    return json.loads(output.stdout)


if __name__ == "__main__":
    print(json.dumps(loop(sys.argv[1], float(sys.argv[2]))))
