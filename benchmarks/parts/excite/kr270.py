"""The paper's pair of runs, optimised against random: deviations of drive gains, K_r and K_0.

Both pairs last equally long, rests and leads included, have the same limits, and go through the same
simulation, filters and maximum likelihood as in `kr270.py`; deviations are those it states. Noise is that of
the drives, one per cent of each joint's rms current in the first random motion, whatever moves.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from common import show

from exidyn.identification.arm.motion import Motion
from exidyn.identification.effects import known_parameters
from exidyn.identification.fit.estimators import ESTIMATORS
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import Sensors, exact_current, simulate
from exidyn.trajectories.planning.planner import plan
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.random_motion import random_fourier

from ..kr270 import MASS, equations_of, gain_error, nominal, plant

TICK = 0.002
NAMES = [f"gain {joint + 1}" for joint in range(6)] + ["K_r", "K_0"]
PAPER = {"K_r": 3.9, "K_0": 2.1}
"""Relative deviations of Table III [%]."""


def optimised(length: float, seconds: float) -> Motion:
    """Motion of a pair that lasts `length`, planned in so many seconds."""
    wishes = Wishes(focus=("gain", "Kr", "K0"), seconds=length, bodies=(known_parameters(MASS),))
    arm = read_model("kr270")
    model = replace(arm, robot=nominal().robot)  # with the catalogue's gains, as the estimator has it
    return plan(model, wishes, seconds=seconds)[0].trajectory.every(TICK).motion()


def record(motion: Motion, noise: np.ndarray) -> list[Recording]:
    """The unloaded and the loaded run with white current noise, shape (n,) [A]."""
    arm, random = plant(), np.random.default_rng(0)
    runs = []
    for name, load in (("unloaded", None), ("loaded", KnownPayload("L", (("M", MASS),)))):
        values, gain = arm.nominal_values, arm.robot.drive_gain
        run = simulate(arm, values, gain, motion, nominal(), Sensors(current_noise=0.0), load, name)
        current = run.signals["current"]
        noisy = current.values + noise * random.normal(size=current.values.shape)
        runs.append(replace(run, signals={**run.signals, "current": replace(current, values=noisy)}))
    return runs


def drive_noise(motion: Motion) -> np.ndarray:
    """One per cent of each joint's rms current in a motion, shape (n,) [A]."""
    arm = plant()
    current = exact_current(arm, arm.nominal_values, arm.robot.drive_gain, motion)
    return 0.01 * np.sqrt(np.mean(current**2, axis=0))


def deviations(motion: Motion, noise: np.ndarray) -> tuple[np.ndarray, float]:
    """Stated relative deviations of `NAMES` [%], and the largest error of a gain [%]."""
    equations = equations_of(record(motion, noise))
    estimate = ESTIMATORS["ml"](equations)
    places = [equations.names.index(name) for name in ("Kr", "K0")]
    found = [*(estimate.gain_std / np.abs(estimate.gain)), *(estimate.std / np.abs(estimate.values))[places]]
    return 100 * np.array(found), float(np.max(np.abs(gain_error(estimate))))


def run(quick: bool) -> dict[str, Any]:
    """Figures and a table."""
    length, seconds, randoms = (10.0, 2.0, 2) if quick else (36.0, 120.0, 10)
    best = optimised(length, seconds)
    duration, limits = float(best.time[-1]), plant().robot.limits
    motions = [random_fourier(limits, duration, seed=seed).at(best.time) for seed in range(randoms)]
    noise = drive_noise(motions[0])
    ours, error = deviations(best, noise)
    others = [deviations(motion, noise)[0] for motion in motions]
    median, luckiest = np.median(others, axis=0), np.min(others, axis=0)
    rows = [
        [name, ours[k], median[k], luckiest[k], median[k] / ours[k], PAPER.get(name)]
        for k, name in enumerate(NAMES)
    ]
    show(
        f"Standard deviations [%] from a pair of {duration:.0f} s, optimised and random ({randoms} motions); "
        f"largest error of a gain {error:.2g} %",
        ["parameter", "optimised", "random, median", "random, best of each", "median / optimised", "paper"],
        rows,
    )
    ratio = median / ours
    return {
        "pair_seconds": duration,
        "gain_std_percent": ours[:6],
        "gain_std_percent_random": median[:6],
        "k_r_std_percent": ours[6],
        "k_0_std_percent": ours[7],
        "k_r_std_percent_random": median[6],
        "k_0_std_percent_random": median[7],
        "std_over_random": 1 / ratio,
        "std_ratio_mean": float(np.exp(np.mean(np.log(ratio)))),
    }
