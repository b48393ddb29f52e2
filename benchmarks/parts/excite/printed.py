"""The condition number that a plan file states beside that of its motion, computed anew.

The motion is read from the file and sampled finely; the regressor of both runs comes from the model, with
friction as it states it; columns are scaled as docs/trajectories.md describes, and singular values are those
of the regressor itself.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from common import Kept, show

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import known_parameters
from exidyn.identification.fit.base_parameters import base_parameters
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.limits.usable_limits import usable
from exidyn.trajectories.planning.goals import nominal_noise, with_bodies
from exidyn.trajectories.planning.planner import plan
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.plans.plan_file import read_plan, write_plan
from exidyn.trajectories.random_motion import random_fourier
from exidyn.trajectories.search.unknowns import with_drive_gains

PAIRS = {
    "KR270 with 175 kg": ("kr270", known_parameters(175.0)),
    "cobot with 8 kg": ("cobot", known_parameters(8.0, (0.1, 0.0, 0.1))),
}
"""Arm, and what is known of its payload."""
SPACING, QUICK_SPACING = 2.5e-4, 2e-3
"""Between samples [s]: a joint that reverses at 5 rad/s^2 passes Coulomb friction's 0.006 rad/s in five."""
SHARE = 0.1**0.5
"""Share of a column's size in random motions below which it counts as small: a tenth of the information."""
RANDOM_TIME = np.arange(3.0, 13.0, 0.01)
"""Samples of a random motion at its full rate [s]."""
SEARCH, QUICK_SEARCH = 15.0, 1.0
"""Duration of a search [s]."""


class PairRegressor:
    """Base regressor of a pair of runs with drive gains unknown, its rows in units of their noise."""

    def __init__(self, model: Model, body: tuple[tuple[str, float], ...], limits: Limits) -> None:
        self.nominal, self.payloads = with_bodies(model, [body])
        self.noise = nominal_noise(self.nominal, limits, self.payloads[-1])
        self.kept = base_parameters(with_drive_gains(self.nominal), self.payloads).kept

    def columns(self, motion: Motion) -> np.ndarray:
        """Columns of both runs over the root of the number of samples, shape (2 t n, b)."""
        runs = [self._run(replace(motion, payload=payload)) for payload in self.payloads]
        return np.concatenate(runs).reshape(-1, len(self.kept)) / np.sqrt(len(motion))

    def _run(self, motion: Motion) -> np.ndarray:
        model, drives = self.nominal, self.nominal.robot.to_motors
        moved = model.loaded(motion)
        torque = model.torque(moved, model.nominal_values) @ drives.T
        gains = torque[:, :, None] * np.eye(model.robot.dof)
        columns = np.concatenate([drives @ model.regressor(moved), gains], axis=2)
        return np.asarray(columns[:, :, self.kept] / self.noise[:, None])


def true_condition(path: Path, model: Model, body: tuple[tuple[str, float], ...], spacing: float) -> float:
    """Condition number of the motion in a plan file."""
    limits, _ = usable(model.robot, Wishes().margins)
    regressor, motion = PairRegressor(model, body, limits), read_plan(path).trajectory
    (series,) = [part for part in getattr(motion, "parts", ()) if isinstance(part, Fourier)]
    columns = regressor.columns(series.at(np.arange(0.0, series.period, spacing)).motion())
    random = [random_fourier(limits, 16.0, seed=seed).at(RANDOM_TIME) for seed in range(4)]
    size = np.sqrt(np.mean([np.sum(regressor.columns(one) ** 2, axis=0) for one in random], axis=0))
    return float(np.linalg.cond(columns / np.maximum(np.linalg.norm(columns, axis=0), SHARE * size)))


def printed_and_true(name: str, seed: int, seconds: float, spacing: float) -> list[float]:
    """Condition number in the file of a pair's plan, and that of its motion."""
    arm, body = PAIRS[name]
    model, wishes = read_model(arm), Wishes(bodies=(body,), criterion="condition")
    with TemporaryDirectory() as folder:
        path = Path(folder) / "trajectory.toml"
        write_plan(plan(model, wishes, seed=seed, seconds=seconds)[0], path)
        return [read_plan(path).reached, true_condition(path, model, body, spacing)]


def run(quick: bool, kept: Kept) -> dict[str, Any]:
    """Both for each pair and seed, and their ratios."""
    seconds, spacing, seeds = (QUICK_SEARCH, QUICK_SPACING, (0,)) if quick else (SEARCH, SPACING, (0, 1))
    cases = {f"{name}, seed {seed}": (name, seed) for name in PAIRS for seed in seeds}
    numbers = {
        case: kept.of(f"printed, {case}", partial(printed_and_true, name, seed, seconds, spacing))
        for case, (name, seed) in cases.items()
    }
    ratios = {case: printed / true for case, (printed, true) in numbers.items()}
    show(
        f"Condition number of a pair with a payload, {seconds:g} s of search",
        ["pair", "printed", "true", "printed / true"],
        [[case, *both, ratios[case]] for case, both in numbers.items()],
    )
    return {"printed_over_true": ratios}
