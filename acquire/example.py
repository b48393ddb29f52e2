"""Recordings of a simulated KR270 for which the truth is known."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from exidyn.identify.effects import Payload, known_parameters
from exidyn.identify.fit import Fit
from exidyn.identify.mcap_file import write_recording
from exidyn.identify.model import Model
from exidyn.identify.motion import Motion
from exidyn.identify.recording import KnownPayload, Recording, Signal
from exidyn.identify.robot_file import read_model
from exidyn.identify.simulate import Sensors, simulate
from exidyn.identify.text_table import at_point, digits, table
from exidyn.trajectories.random_fourier import random_fourier

RATE = 500.0
"""Samples a second [Hz], as robot controllers give them."""

MASS = 175.0
"""Payload [kg], as in the paper; nothing but this is told to the identification."""

BODY = known_parameters(MASS, com=(0.05, 0.03, -0.22), inertia=(8.0, 0.1, 0.2, 9.0, 0.3, 7.0))
"""What the payload really is: a tool some twenty centimetres in front of the flange, which looks along -z."""

NOISE = 0.01
"""Current noise of each joint over its rms current in the unloaded run, the same in all runs [-]."""

REST = 3.0
"""Time at rest before and after the motion [s], from which the noise floor is measured: 1 s tells it to a
quarter, 3 s to a tenth."""

GAIN_ERROR = 0.1
"""By how much the drive gains are believed too large; the paper found data sheets 8 to 19 % off."""


@dataclass(frozen=True)
class Example:
    """An arm as it is, and recordings of it that believe wrong drive gains.

    Attributes:
        truth: The arm as it is, its beliefs being true.
        unloaded: Run without payload.
        loaded: The same motion with a payload of which the mass is told.
        other: Another motion without payload, to validate on.
    """

    truth: Model
    unloaded: Recording
    loaded: Recording
    other: Recording


def simulated_example(robot: str = "kr270", seconds: float = 40.0) -> Example:
    """Simulate the three runs: current noise as in `NOISE`, encoders with steps of a few microradians."""
    truth = read_model(robot)
    wrong = replace(
        truth.robot, drive_gain=(1 + GAIN_ERROR) * truth.robot.drive_gain, drive_gain_tolerance=GAIN_ERROR
    )
    believed, plant = replace(truth, robot=wrong), truth + Payload("L", BODY)
    time = np.arange(0.0, seconds, 1 / RATE)
    one, other = (
        replace(random_fourier(truth.robot.limits, seconds, seed=seed), rest=REST).at(time) for seed in (0, 1)
    )
    told = KnownPayload("L", known_parameters(MASS))
    runs = [
        _run(plant, truth, believed, motion, name, seed, payload)
        for seed, (name, motion, payload) in enumerate(
            (("unloaded", one, None), ("loaded", one, told), ("other", other, None)), 1
        )
    ]
    spread = NOISE * np.sqrt(np.mean(runs[0].signals["current"].values ** 2, axis=0))
    return Example(truth, *(_noisy(run, spread, seed) for seed, run in enumerate(runs, 101)))


def _run(
    plant: Model,
    truth: Model,
    believed: Model,
    motion: Motion,
    name: str,
    seed: int,
    payload: KnownPayload | None,
) -> Recording:
    """A run without current noise."""
    sensors = Sensors(current_noise=0.0)
    values, gain = truth.believed_values, truth.robot.drive_gain
    return simulate(plant, values, gain, motion, believed, sensors, payload, name, seed)


def _noisy(run: Recording, spread: np.ndarray, seed: int) -> Recording:
    """The run with white current noise of the given standard deviations (n,) [A]."""
    current = run.signals["current"]
    noise = spread * np.random.default_rng(seed).normal(size=current.values.shape)
    return replace(run, signals={**run.signals, "current": Signal(current.time, current.values + noise)})


def write_example(example: Example, folder: Path) -> tuple[Path, Path, Path]:
    """Write the runs into a folder: unloaded, loaded, other.

    The loaded run is written without its payload, so that the command that is shown tells the mass.
    """
    folder.mkdir(parents=True, exist_ok=True)
    runs = (example.unloaded, replace(example.loaded, payload=None), example.other)
    paths = tuple(folder / f"{run.name}.mcap" for run in runs)
    for run, path in zip(runs, paths, strict=True):
        write_recording(run, path)
    return paths[0], paths[1], paths[2]


def comparison(fit: Fit, truth: Model) -> str:
    """Identified drive gains and spring beside the true ones."""
    joints, estimate = truth.robot.joints, fit.estimate
    rows = [
        (f"drive gain {joint}", "N m/A", *numbers)
        for joint, *numbers in zip(
            joints,
            truth.robot.drive_gain,
            fit.model.robot.drive_gain,
            estimate.gain,
            estimate.gain_std,
            strict=True,
        )
    ]
    true = dict(zip(truth.names, truth.believed_values, strict=True))
    for name, meaning in (("Kr", "spring stiffness K_r"), ("K0", "spring preload K_0")):
        if name in fit.names:
            row = fit.names.index(name)
            believed = fit.believed[0][row]
            rows.append(
                (meaning, fit.base.units[row], true[name], believed, estimate.values[row], estimate.std[row])
            )
    real, believed, found, std = np.array([row[2:] for row in rows]).T
    texts = [at_point([digits(v) for v in column]) for column in (real, believed, found)]
    for column in (100 * (found / real - 1), 100 * std / np.abs(found), (found - real) / std):
        texts.append([f"{v:.3f}" for v in column])
    head = ["", "unit", "true", "believed", "identified", "error %", "std %", "error/std"]
    labels = ([row[0] for row in rows], [row[1] for row in rows])
    return "\n".join(table(head, [list(row) for row in zip(*labels, *texts, strict=True)], left=(0, 1)))
