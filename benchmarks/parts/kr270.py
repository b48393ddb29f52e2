"""The paper's experiment on a simulated KR270: its two runs, their equations, errors, edit tests.

Coverage: Whether 95 % intervals hold the truth, over arms whose values and drive gains are drawn.

Each arm is the nominal one with every parameter and gain wrong by a normal draw of its tolerance. Two runs,
one with a payload of which only the mass is stated, give its gains; the unloaded run alone is fitted with the
nominal ones. Half of the current noise is white, and half lasts for `MEMORY`, so that residuals are coloured.
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from typing import Any, NamedTuple

import numpy as np
from common import Kept, show
from scipy import signal

from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.fit.base_parameters import base_parameters
from exidyn.identification.fit.edit_test import edit_tests
from exidyn.identification.fit.equations import Equations, assemble
from exidyn.identification.fit.estimators import Estimate
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import common_filtering, identify
from exidyn.identification.model import Model
from exidyn.identification.preparation.prepare import Filtering, prepare
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import Sensors, simulate
from exidyn.identification.text_table import NORMAL_95
from exidyn.trajectories.random_motion import random_fourier

MASS = 175.0
BODY = known_parameters(MASS, com=(0.04, -0.03, -0.219), inertia=(8.0, 0.1, 0.2, 9.0, 0.3, 7.0))
"""The true payload; MZL is the paper's -38.3 kg m. The estimators get the mass alone."""
CATALOGUE = np.array([-299.0, -389.0, -367.0, -258.0, -258.0, 183.0])
"""Manufacturer's drive gains, Table III, third column [N m/A]."""


def plant() -> Model:
    """The arm that is recorded."""
    return read_model("kr270") + Payload("L", BODY)


def nominal(given: Sequence[tuple[str, float]] = (("M", MASS),)) -> Model:
    """What the identification starts from."""
    model = read_model("kr270")
    robot = replace(model.robot, drive_gain=CATALOGUE, drive_gain_tolerance=np.full(model.robot.dof, 0.2))
    return replace(model, robot=robot) + Payload("L", tuple(given))


def record(
    seed: int, sensors: Sensors, swing: float = 1.0, seconds: float = 40.0, motion: int = 0
) -> list[Recording]:
    """The unloaded and the loaded run; `swing` narrows the range of joint 2."""
    model, arm = nominal(), plant()
    limits = model.robot.limits
    lower, upper = limits.position_lower.copy(), limits.position_upper.copy()
    middle, half = 0.5 * (lower[1] + upper[1]), 0.5 * (upper[1] - lower[1])
    lower[1], upper[1] = middle - swing * half, middle + swing * half
    path = random_fourier(
        replace(limits, position_lower=lower, position_upper=upper), seconds, seed=motion
    ).at(np.arange(0.0, seconds, 0.002))
    gain = arm.robot.drive_gain
    values = arm.nominal_values
    loads = (None, KnownPayload("L", (("M", MASS),)))
    return [
        simulate(arm, values, gain, path, model, sensors, load, name, seed=2 * seed + k)
        for k, (load, name) in enumerate(zip(loads, ("unloaded", "loaded"), strict=True))
    ]


def equations_of(runs: Sequence[Recording], filtering: Filtering | None = None) -> Equations:
    """Filtered equations of both runs."""
    filtering = filtering or common_filtering(runs, Filtering())
    base = base_parameters(runs[0].model, ("", "L"))
    return assemble(runs[0].model, base, [prepare(run, filtering) for run in runs])


def true_base(equations: Equations) -> np.ndarray:
    """Base values of the arm that was recorded."""
    arm = dict(zip(plant().names, plant().nominal_values, strict=True))
    arm |= {f"{name}L": value for name, value in BODY}
    return equations.base.regrouping @ [arm[p.name] for p in equations.base.parameters]


def gain_error(estimate: Estimate) -> np.ndarray:
    """Error of the six drive gains [%]."""
    return np.round(100 * (estimate.gain / plant().robot.drive_gain - 1), 4)


def over_std(estimate: Estimate, equations: Equations, name: str) -> float:
    """Error of a base parameter over its standard deviation."""
    place = equations.names.index(name)
    return float((estimate.values - true_base(equations))[place] / estimate.std[place])


def edit_test_table(title: str, fits: Mapping[str, Fit]) -> dict[str, Any]:
    """One row an edit test and one for the runs beside it; gives the residuals [N m] by fit and run."""
    rows: list[list[Any]] = []
    figures: dict[str, Any] = {}
    for label, fit in fits.items():
        tests = edit_tests(fit)
        kind = "held out" if tests[0].held_out else "used"
        rows.append([label, f"runs {kind}, residual", *tests[0].beside])
        for test in tests:
            rows.append(["", f"{test.run}, residual", *test.residual])
            rows.append(["", "  over torque [%]", *(100.0 * test.relative)])
            figures[f"{label}: {test.run}"] = {
                "residual": test.residual,
                "relative": test.relative,
                "beside": test.beside,
            }
    joints = [f"J{j + 1}" for j in range(next(iter(fits.values())).model.robot.dof)]
    show(title, ["edit", "run [N m]", *joints], rows)
    return figures


TOLERANCE = 0.1
"""Relative deviation of true values and gains from nominal ones, as data sheets of gains are wrong [-]."""
CARRIED = {"kr270": 175.0, "cobot": 8.0}
"""Payload of each arm [kg]."""
RATE, SECONDS, MEMORY = 200.0, 20.0, 0.05
"""Samples a second [Hz], length of a run [s], and after which 37 % is left of half of the noise [s]."""
NOISE = 0.01
"""Deviation of each half of the current noise over the rms current [-]."""


class Held(NamedTuple):
    """One arm's errors over deviations: base values, then gains; and of the fit with nominal gains."""

    values: list[float]
    gains: list[float]
    nominal: list[float]


@dataclass(frozen=True)
class Arm:
    """A drawn arm: its name, its number, and the length of its runs [s]."""

    name: str
    number: int
    seconds: float = SECONDS


def held(arm: Arm) -> Held:
    """Draw an arm, record it, and identify it with and without its payload."""
    random = np.random.default_rng(1000 + arm.number)
    nominal, mass = _nominal(arm.name), CARRIED[arm.name]
    body = known_parameters(
        mass, (0.05, 0.03, -0.22), 0.05 * mass * np.array([1.0, 0.01, 0.02, 1.1, 0.03, 0.9])
    )
    loaded = nominal + Payload("L", body)
    values = loaded.nominal_values * (1.0 + TOLERANCE * random.normal(size=len(loaded.names)))
    true = dict(zip(loaded.names, values, strict=True)) | {f"{name}L": value for name, value in body}
    gain = nominal.robot.drive_gain * (1.0 + TOLERANCE * random.normal(size=nominal.robot.dof))
    runs = [_run(arm, model, values, gain, nominal, k, random) for k, model in enumerate((nominal, loaded))]
    found, alone = identify(runs, filtering=Filtering()), identify(runs[:1], filtering=Filtering())
    gains = (found.estimate.gain - gain) / found.estimate.gain_std
    return Held(_errors(found, true), gains.tolist(), _errors(alone, true))


def _nominal(name: str) -> Model:
    model = read_model(name)
    tolerance = np.full(model.robot.dof, TOLERANCE)
    return replace(model, robot=replace(model.robot, drive_gain_tolerance=tolerance))


def _run(
    arm: Arm, plant: Model, values: np.ndarray, gain: np.ndarray, nominal: Model, k: int,
    random: np.random.Generator,
) -> Recording:  # fmt: skip
    """The unloaded run, k = 0, or the loaded one, on the arm's own motion."""
    motion = random_fourier(nominal.robot.limits, arm.seconds, seed=arm.number)
    path = motion.at(np.arange(0.0, arm.seconds, 1.0 / RATE))
    payload = KnownPayload("L", (("M", CARRIED[arm.name]),)) if k else None
    sensors, own = Sensors(current_noise=NOISE), values[: len(plant.names)]
    run = simulate(
        plant, own, gain, path, nominal, sensors, payload, ("alone", "loaded")[k], 2 * arm.number + k
    )
    current = run.signals["current"]
    usual = np.sqrt(np.mean(current.values**2, axis=0))
    lasting = current.values + NOISE * usual * _lasting(current.values.shape, random)
    return replace(run, signals=run.signals | {"current": replace(current, values=lasting)})


def _lasting(shape: tuple[int, ...], random: np.random.Generator) -> np.ndarray:
    """Noise (t, n) of deviation one, of which 37 % is left after `MEMORY`."""
    share = np.exp(-1.0 / (RATE * MEMORY))
    return signal.lfilter([np.sqrt(1.0 - share**2)], [1.0, -share], random.normal(size=shape), axis=0)


def _errors(fit: Fit, true: dict[str, float]) -> list[float]:
    """Error of each base parameter over its deviation."""
    truth = fit.base.regrouping @ [true[parameter.name] for parameter in fit.base.parameters]
    return ((fit.estimate.values - truth) / fit.estimate.std).tolist()


def coverage(arms: Sequence[Arm], kept: Kept) -> dict[str, float]:
    """Shares of intervals that hold the truth [%]; arms that are kept are not made again."""
    left = [arm for arm in arms if _key(arm) not in kept.found]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        for arm, one in zip(left, pool.map(held, left), strict=True):
            kept.put(_key(arm), one)
    every = [Held(*kept.found[_key(arm)]) for arm in arms]
    identified = [one.values + one.gains for one in every]
    return {
        "coverage_95": _share(identified),
        "coverage_95_gains": _share([one.gains for one in every]),
        "coverage_95_nominal_gains": _share([one.nominal for one in every]),
        "coverage_95_std": _scatter(identified),
        "coverage_95_nominal_gains_std": _scatter([one.nominal for one in every]),
    }


def _share(errors: Sequence[Sequence[float]]) -> float:
    return 100.0 * float(np.mean(np.abs(np.concatenate(errors)) < NORMAL_95))


def _scatter(errors: Sequence[Sequence[float]]) -> float:
    """Standard deviation of a share over arms [%]; the intervals of one arm are not independent."""
    return float(np.std([_share([one]) for one in errors]) / np.sqrt(len(errors)))


def _key(arm: Arm) -> str:
    return f"{arm.name} {arm.number} {arm.seconds:g} s"
