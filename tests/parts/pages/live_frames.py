"""An arm that moves, as the frames of a run: current by inverse dynamics, noise of real sensors, events."""

from dataclasses import replace

import numpy as np

from exidyn.acquire.run.frames import END, Event, event_frame, sample_frame, text_frame
from exidyn.acquire.run.recorder import RunHead
from exidyn.drivers import Command, Sample
from exidyn.identification.effects import Payload
from exidyn.identification.simulation.simulate import Sensors, exact_current
from exidyn.trajectories.random_motion import random_fourier

SENSORS = Sensors(current_noise=0.01, encoder_noise=1e-6, encoder_step=4e-6)
EPOCH = 1_700_000_000_000_000_000
SECOND = 1_000_000_000
LAG = 2
"""Cycles by which the drives follow late."""


def measured(model, seconds, rate=500.0, hidden=(), seed=0, sensors=SENSORS, begin=0.0):
    """A motion, and what is measured of it: position and current (t, n); `hidden` hangs on the flange."""
    time = np.arange(0.0, seconds, 1 / rate)
    motion = random_fourier(model.robot.limits, max(begin + seconds, 20.0), seed=seed).at(begin + time)
    motion = replace(motion, time=time, payload="hidden")
    plant = model + Payload("hidden", hidden) if hidden else model
    current = exact_current(plant, plant.nominal_values, model.robot.drive_gain, motion)
    random = np.random.default_rng(seed)
    usual = np.sqrt(np.mean(current**2, axis=0))
    current = current + sensors.current_noise * usual * random.normal(size=current.shape)
    position = motion.position + sensors.encoder_noise * random.normal(size=current.shape)
    return motion, np.round(position / sensors.encoder_step) * sensors.encoder_step, current


def head(model, **options):
    return RunHead("live", model, signals=("position", "current"), epoch=EPOCH, **options).frame()


def frames(model, seconds, rate=500.0, hidden=(), start=EPOCH, stop=True, explained=None):
    """Due time [s] and frame, in order: half a second of listening, then the motion, then a stop."""
    motion, position, current = measured(model, seconds, rate, hidden)
    lateness = np.abs(np.random.default_rng(1).normal(scale=8e-5, size=len(motion)))
    skipped = np.zeros(len(motion), int)
    late = np.arange(len(motion) // 3, len(motion), max(len(motion) // 3, 1))
    skipped[late[:2]], lateness[late[:2]] = (2, 1), (1.3e-3, 0.9e-3)
    listening = round(0.5 * rate)
    yield 0.0, explained or head(model)
    yield 0.0, event(start, "stage", "listening")
    for k in range(len(motion)):
        due = motion.time[k]
        now = start + round(due * SECOND)
        if k == listening:
            yield due, event(now, "stage", "running")
        if skipped[k]:
            yield due, event(now, "late", f"{skipped[k]} cycles went by without an exchange")
        ahead = min(k + LAG, len(motion) - 1)
        command = Command(motion.position[ahead], motion.velocity[ahead]) if k >= listening else None
        unknown = np.full(model.robot.dof, np.nan)
        sample = Sample(
            now,
            now - start,
            position[k],
            unknown,
            current[k],
            unknown,
            unknown,
            lateness=float(lateness[k]),
            skipped=int(skipped[k]),
        )
        yield due, sample_frame(sample, command, 2 if k >= listening else 0)
    if stop:
        text = "joint2: tracking error 0.041 rad, limit 0.035"
        yield due, event(now, "stop", text, joint="joint2", value=0.041, limit=0.035, unit="rad")
        yield due, event(now, "stage", "braking")
    yield due, text_frame(END, {"text": text, "stop": "tracking"} if stop else {"text": "the arm stands"})


def event(now, kind, text, **details):
    return event_frame(Event(now, now - EPOCH, kind, text, details))
