"""Weekly runs of two-joint arms over a season: as summaries, quickly, and as files."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from exidyn.identification.fit.equations import Equations, assemble
from exidyn.identification.fleet.kind import Kind
from exidyn.identification.fleet.runs import Run
from exidyn.identification.fleet.summary import held, reduced
from exidyn.identification.preparation.prepare import prepare
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.simulation.simulate import simulate

from . import two_joints

START = 20454.0
"""1 January 2026 [d since 1970]."""
SCATTER = 0.005
"""Of friction from run to run [-]."""
REFERENCE = 30.0
BODY = np.array([0.3, 0.0, 0.1, 0.4, 0.0, 0.3, 1.5, 0.2, 0.8, 4.0])
"""XX to M of a body about the last joint."""
Wear = Callable[[float, dict[str, float], np.ndarray], None]
"""Changes values by name, and gains, in so many weeks."""


def sound(weeks: float, values: dict[str, float], gain: np.ndarray) -> None:
    """Nothing changes."""


@cache
def kind_and_equations() -> tuple[Kind, Equations]:
    """The type of the arm, and the equations of its check run, without noise."""
    recording = check_run({}, two_joints.GAIN, np.full(2, REFERENCE), 0.0)
    kind = Kind.of(recording)
    prepared = prepare(replace(recording, model=kind.model), kind.filtering)
    return kind, held(assemble(kind.model, kind.base, [prepared]), kind, True)


def check_run(
    values: dict[str, float], gain: np.ndarray, temperature: np.ndarray, day: float, seed: int = 0
) -> Recording:
    """A recording of 10 s."""
    plant = two_joints.model()
    given = dict(zip(plant.names, two_joints.true_values(plant), strict=True)) | values
    time = np.arange(0.0, 10.0, 0.004)
    true = np.array([given[name] for name in plant.names])
    found = simulate(plant, true, gain, two_joints.trajectory(10.0).at(time), plant, seed=seed)
    warm = Signal(time[::50], np.tile(temperature, (len(time[::50]), 1)))
    host = np.round(day * 86400e9).astype(np.int64) + np.round(time * 1e9).astype(np.int64)
    return replace(found, signals={**found.signals, "temperature": warm}, host_time=host)


def state(
    week: int, random: np.random.Generator, wear: Wear
) -> tuple[dict[str, float], np.ndarray, np.ndarray]:
    """Friction by name, gains and temperatures of a week."""
    warm = 10.0 * np.sin(2.0 * np.pi * week / 26.0) + 3.0 * random.normal(size=2)
    values = {
        name: value * np.exp(-by * warm[int(name[2:]) - 1]) * (1.0 + SCATTER * random.normal())
        for name, value, by in (
            ("Fv1", 3.0, 0.025),
            ("Fv2", 1.5, 0.025),
            ("Fc1", 4.0, 0.004),
            ("Fc2", 2.0, 0.004),
        )
    }
    gain = two_joints.GAIN.copy()
    wear(float(week), values, gain)
    return values, gain, REFERENCE + warm


def season(seed: int, wear: Wear = sound, weeks: int = 26, bodies: Sequence[int] = ()) -> list[Run]:
    """Runs of an arm, a week apart; in some weeks with a body of which nothing is known."""
    kind, equations = kind_and_equations()
    random, runs = np.random.default_rng(seed), []
    names = kind.base.names
    usual = dict(zip(two_joints.model().names, two_joints.true_values(two_joints.model()), strict=True))
    own = {name: 1.0 + 0.1 * random.normal() for name in ("Fv1", "Fv2", "Fc1", "Fc2")}
    base = kind.base.regrouping[:, : len(usual)] @ np.array(list(usual.values()))
    for week in range(weeks):
        values, gain, temperature = state(week, random, wear)
        true = base.copy()
        for name, value in values.items():
            true[names.index(name)] = value * own[name]
        carries = week in bodies
        true = true + carries * (kind.base.regrouping[:, kind.model.inertias[-1]] @ BODY)
        current = (equations.regressor @ true) / gain
        noise = 0.002 * np.sqrt(np.mean(current**2, axis=0)) * random.normal(size=current.shape)
        said = reduced(replace(equations, current=current + noise), temperature, "", not carries, 10.0)
        runs.append(Run(f"{seed}-{week}", START + 7.0 * week, said))
    return runs


def write_season(folder: Path, arms: int, weeks: int) -> None:
    """The same as files, a folder an arm."""
    for arm in range(arms):
        random = np.random.default_rng(arm)
        for week in range(weeks):
            values, gain, temperature = state(week, random, sound)
            seed = 100 * arm + week
            run = check_run(values, gain, temperature, START + 7.0 * week, seed)
            path = folder / f"arm {arm + 1}" / f"week-{week:02}.mcap"
            path.parent.mkdir(parents=True, exist_ok=True)
            write_recording(run, path)
