"""Runs that are handed to a recorder as fast as it takes them, with numbers that are known."""

import time

import numpy as np

from exidyn.acquire.run.frames import END, Event, event_frame, sample_frame, text_frame
from exidyn.acquire.run.recorder import RunHead, start_recorder
from exidyn.drivers import Command, Sample
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.robot_files.robot_file import read_model

MODEL = read_model("cobot")
N = MODEL.robot.dof
HOST, CONTROLLER, STEP = 1_800_000_000_000_000_000, 7_000_000_000, 2_000_000
NOTHING = np.full(N, np.nan)
RANDOM = np.random.default_rng(0)
NUMBERS = RANDOM.normal(size=(40_000, 4, N)) * 1e-2


def head(**other):
    given = {
        "name": "a run",
        "model": MODEL,
        "signals": ("position", "current", "temperature"),
        "epoch": HOST,
        "zero": CONTROLLER,
        "trajectory": "x = 1\n",
        "payload": KnownPayload("weight", (("M", 3.0),)),
        "settings": {"driver": "mock"},
        "warnings": ("suspicious",),
    }
    return RunHead(**(given | other))


def cycle(number, commanded=True, stage=2, **other):
    """Frame of a cycle; three microseconds late on average, every hundredth has skipped two."""
    position, current, temperature, velocity = NUMBERS[number % len(NUMBERS)]
    measured = {
        "position": position,
        "velocity": NOTHING,
        "current": current,
        "torque": NOTHING,
        "temperature": 40.0 + temperature if number % 10 == 0 else NOTHING,
        "lateness": 1e-6 * (number % 7),
        "skipped": 2 * (number % 100 == 99),
    }
    measured["host_time"] = HOST + number * STEP + 1000 * (number % 3)
    measured["controller_time"] = CONTROLLER + number * STEP
    sample = Sample(**(measured | other))
    return sample_frame(sample, Command(position + 1e-3, velocity) if commanded else None, stage)


def event(number, kind="driver", text="something happened", **details):
    return event_frame(Event(HOST + number * STEP, CONTROLLER + number * STEP, kind, text, details))


def end(**options):
    return text_frame(END, {"stop": "none"} | options)


def record(path, frames):
    """Record frames; the sink, closed."""
    with start_recorder(path) as sink:
        for frame in frames:
            sink.put(frame)
    return sink


def record_until_failure(sink, most, after=0):
    """Hand cycles over, ten times as fast as in real life, until some after a failure; their number."""
    left = after
    for number in range(most):
        sink.put(cycle(number))
        if number % 250 == 0:
            time.sleep(0.05)
        if sink.failure:
            left -= 1
        if left < 0:
            break
    return number + 1
