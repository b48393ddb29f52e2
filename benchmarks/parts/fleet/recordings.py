"""Check runs of simulated arms as files: 20 s at 500 Hz, one a week, over a season's temperatures."""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.effects import Payload
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import KnownPayload, Signal
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import Sensors, simulate
from exidyn.trajectories.random_motion import random_fourier

from .arms import REFERENCE, Arm

SECONDS, RATE = 20.0, 500.0
START = 20454.0
"""Day of the first run: 1 January 2026."""
WEEK = 7.0
SEASON, DAILY, OWN = 10.0, 3.0, 1.0
"""Temperature: half the swing of half a year, deviation of a day and of a joint [K]."""
PART = KnownPayload("part", tuple(zip(("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M"),
    (0.05, 0.0, 0.0, 0.05, 0.0, 0.04, 0.05, 0.0, 0.4, 5.0), strict=True)))  # fmt: skip
"""A body that every fourth run carries."""


@lru_cache
def motion(kind: str) -> Motion:
    """What a type's check run does."""
    time = np.arange(0.0, SECONDS, 1.0 / RATE)
    return random_fourier(read_model(kind).robot.limits, SECONDS, seed=5).at(time)


def weather(arm: Arm, run: int, begin: float, random: np.random.Generator) -> tuple[float, float, np.ndarray]:
    """Day of a run, weeks since its arm's wear began, and joint temperatures (n,) [degC]."""
    day = START + WEEK * run + random.uniform(0.2, 0.8)
    season = SEASON * np.sin(2.0 * np.pi * (day - START) / (26.0 * WEEK) + len(arm.name))
    own = OWN * random.normal(size=arm.nominal.robot.dof)
    return day, (day - START) / WEEK - begin, REFERENCE + season + DAILY * random.normal() + own


def write(folder: Path, kind: str, arm: Arm, run: int, begin: float) -> Path:
    """Make a run, unless it is there; its wear begins in week `begin`."""
    path = folder / arm.name / f"run-{run:03}.mcap"
    if path.exists():
        return path
    random = np.random.default_rng([run, *arm.name.encode()])
    day, worn, temperature = weather(arm, run, begin, random)
    payload = PART if random.uniform() < 0.25 else None
    plant = arm.built + Payload(PART.name, PART.known) if payload else arm.built
    recording = simulate(
        plant,
        arm.values(temperature, worn, random),
        arm.gains(worn),
        motion(kind),
        arm.nominal,
        Sensors(current_noise=arm.noise),
        payload,
        f"{arm.name} {run}",
        int(random.integers(2**31)),
    )
    time = recording.signals["position"].time
    slow = Signal(time[::50], temperature + 0.1 * random.normal(size=(len(time[::50]), len(temperature))))
    host = np.round(day * 86400e9).astype(np.int64) + np.round(time * 1e9).astype(np.int64)
    recording = replace(recording, signals={**recording.signals, "temperature": slow}, host_time=host)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_recording(recording, path)
    return path
