"""Who writes while the loop runs: a thread of its own process, or a process of its own?

A 500 Hz loop with real-time scheduling hands over six joints to nobody, to a thread and to a process, which
write the same file in the same way, on a quiet machine and beside two busy processes. Each is run in a
process of its own. Compared is how late the loop is, and how long it takes to hand over.
"""

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

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from busy import busy
from common import options, save, show

from exidyn.acquire.run.pipe.frames import END, read_cycle, sample_frame, text_frame
from exidyn.acquire.run.pipe.pipe_sink import PipeSink
from exidyn.acquire.run.pipe.run_head import RunHead
from exidyn.acquire.run.realtime import realtime
from exidyn.acquire.run.recording.disk_file import DiskFile
from exidyn.acquire.run.recording.recorder import start_recorder
from exidyn.acquire.run.recording.recorder_process import FLUSH
from exidyn.acquire.run.recording.run_file import RunFile
from exidyn.drivers.host_clock import HostClock, host_time

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "peers"))
from frame_source import CYCLE, head, sample

WHO = ("nobody", "thread", "process")
HEAD_ROOM = 5
"""Bytes before the body of a frame."""


class Nobody:
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


def sink_of(who: str, path: Path) -> Nobody | InThread | PipeSink:
    """Ready to take frames; started before the loop's scheduling, which it must not inherit."""
    if who == "process":
        sink = start_recorder(path)
        sink.put(head(host_time()).frame())
        return sink
    return InThread(path) if who == "thread" else Nobody()


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


def cpu(sink: Nobody | InThread | PipeSink) -> float:
    """CPU time of this process and of the one that writes [s]."""
    processes = [os.getpid()] + ([sink.process_id] if isinstance(sink, PipeSink) else [])
    times = [
        Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[11:13] for process in processes
    ]
    return sum(int(ticks) for pair in times for ticks in pair) / os.sysconf("SC_CLK_TCK")


def measured(who: str, load: int, seconds: float) -> dict[str, Any]:
    """Figures of one case."""
    with busy(load):
        command = [sys.executable, __file__, "--loop", who, str(seconds)]
        text = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
    return json.loads(text)


def main() -> None:
    if sys.argv[1:2] == ["--loop"]:
        print(json.dumps(loop(sys.argv[2], float(sys.argv[3]))))
        return
    chosen = options(__doc__.splitlines()[0])
    seconds = 5.0 if chosen.quick else 30.0
    found = {(load, who): measured(who, load, seconds) for load in (0, 2) for who in WHO}
    rows = [
        ["busy" if load else "quiet", who, *f["lateness_us"], f["skipped"], *f["put_us"], 100 * f["cpu"]]
        for (load, who), f in found.items()
    ]
    header = [
        "machine",
        "written by",
        "late p50 us",
        "p99 us",
        "max us",
        "skipped",
        "put p50 us",
        "p99 us",
        "CPU %",
    ]
    show(f"A 500 Hz loop of {seconds:g} s handing over six joints", header, rows)
    if not all(figures["real_time"] for figures in found.values()):
        print("real-time scheduling was refused: all loops were scheduled as usual")
    ratio = {
        load: found[load, "thread"]["lateness_us"][1] / found[load, "process"]["lateness_us"][1]
        for load in (0, 2)
    }
    print(f"p99 of lateness, thread over process: {ratio[0]:.2f} quiet, {ratio[2]:.2f} busy")
    save(chosen.json, {"thread_over_process_p99": ratio[2], "thread_over_process_p99_quiet": ratio[0]})


if __name__ == "__main__":
    main()
