"""A program that hands the frames of a simulated run to a recorder, as the loop does, until it is stopped.

    python tests/peers/frame_source.py MCAP PROGRESS SECONDS

PROGRESS is a file of sixteen bytes: the host's clock when the run began and at the last sample handed over
[ns], right even when this program is killed. Prints `ready`, its recorder's process id, and at the end what
became of the recording.
"""

import mmap
import struct
import sys
from pathlib import Path

import numpy as np

from exidyn.acquire.run.frames import END, Event, event_frame, sample_frame, text_frame
from exidyn.acquire.run.recorder import RunHead, start_recorder
from exidyn.drivers import Command, Sample
from exidyn.drivers.host_clock import HOST, HostClock
from exidyn.identification.robot_files.robot_file import read_model

MODEL = read_model("cobot")
N = MODEL.robot.dof
CYCLE = 0.002


def sample(number, now, lateness=0.0, skipped=0):
    """Numbers that no other cycle has, and that compress as badly as measured ones."""
    noise = np.random.default_rng(number).normal(size=(4, N))
    position, velocity, current, temperature = noise[0] * 1e-3, noise[1], noise[2], 40 + noise[3]
    nothing = np.full(N, np.nan)
    time = number * round(CYCLE * 1e9)
    measured = (position, velocity, current, nothing, temperature)
    return Sample(now, time, *measured, lateness, skipped), Command(position, velocity)


def head(now):
    signals = ("position", "velocity", "current", "temperature")
    return RunHead(
        "killed", MODEL, signals=signals, epoch=now, trajectory="x = 1\n", settings={"driver": "none"}
    )


def main(path, progress, seconds):
    with start_recorder(Path(path)) as sink, open(progress, "r+b") as file:
        handed = mmap.mmap(file.fileno(), 16)
        now = HOST.host_time()
        struct.pack_into("<q", handed, 0, now)
        sink.put(head(now).frame())
        sink.put(event_frame(Event(now, 0, "driver", "begun", {})))
        clock = HostClock(CYCLE)
        print("ready", sink.process_id, flush=True)
        for _ in range(round(seconds / CYCLE)):
            tick = clock.wait()
            now = HOST.host_time()
            sink.put(sample_frame(*sample(tick.number, now, tick.lateness, tick.skipped), 2))
            if sink.failure:
                break
            struct.pack_into("<q", handed, 8, now)
        sink.put(text_frame(END, {"stop": "none"}))
        handed.close()
    print("failure", sink.failure or "none", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], float(sys.argv[3]))
