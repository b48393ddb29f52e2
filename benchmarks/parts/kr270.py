"""The paper's experiment on a simulated KR270: its two runs, their equations, errors, edit tests."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from common import show

from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.fit.base_parameters import base_parameters
from exidyn.identification.fit.edit_test import edit_tests
from exidyn.identification.fit.equations import Equations, assemble
from exidyn.identification.fit.estimators import Estimate
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import common_filtering
from exidyn.identification.model import Model
from exidyn.identification.preparation.prepare import Filtering, prepare
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import Sensors, simulate
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
