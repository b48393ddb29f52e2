"""The goal of identifying a model: from priors alone, or from what an earlier fit knows."""

from dataclasses import replace

import numpy as np

from exidyn.identify.arm.robot import Limits
from exidyn.identify.effects import Payload, Prior, known_parameters
from exidyn.identify.model import Model

from ..errors import UnknownChoice
from ..families.fourier import Fourier
from ..search.information.criteria import CRITERIA, Criterion, Focus
from ..search.information.experiment import Experiment
from ..search.information.goals import Identify
from ..search.information.unknowns import with_drive_gains, with_shapes
from ..search.shrink import inside_kinematics
from .goal_after_fit import after_fit
from .wishes import Wishes, rows_of

NOISE = 0.01
"""Torque noise where none was measured, as a share of each joint's rms torque in a random motion: the
currents of industrial drives, at 500 Hz, scatter by one per cent."""
DENSITY = 4000.0
"""Of a body on a flange [kg/m^3]: half of steel, since test weights are plates with gaps between them."""


def identification_goal(model: Model, wishes: Wishes, limits: Limits) -> Identify:
    """To identify the model's parameters, and the drive gains where a pair of runs can."""
    if wishes.criterion not in CRITERIA:
        raise UnknownChoice("criterion", wishes.criterion, CRITERIA)
    payloads: tuple[str, ...] = ("",)
    nominal = model
    if wishes.payload is not None:
        nominal, payloads = with_payload(model, wishes.payload), ("", "L")
    if wishes.fit is not None:
        return after_fit(wishes.fit, nominal, payloads, wishes)
    asked = with_shapes(nominal, wishes.shapes)
    asked = with_drive_gains(asked) if wishes.payload is not None else asked
    experiment = Experiment.of(asked, payloads, nominal_noise(nominal, limits, payloads[-1]))
    criterion: Criterion = CRITERIA[wishes.criterion]
    if wishes.focus:
        criterion = Focus.on(experiment.base.names, wishes.focus)
    return Identify(experiment, criterion, rows_of(wishes), nominal)


def nominal_noise(model: Model, limits: Limits, payload: str = "") -> np.ndarray:
    """Noise of each drive's torque where none was measured, shape (n,) [N m]; see `NOISE`."""
    n, random = model.robot.dof, np.random.default_rng(0)
    middle = 0.5 * (limits.position_lower + limits.position_upper)
    series = inside_kinematics(Fourier(10.0, middle, *random.normal(size=(2, n, 5))), limits, 0.9)
    motion = model.loaded(series.at(np.linspace(0.0, 10.0, 500)).motion(payload))
    on_motors = model.torque(motion, model.nominal_values) @ model.robot.to_motors.T
    rms = np.sqrt(np.mean(on_motors**2, axis=0))
    largest = float(np.max(rms))
    return NOISE * np.maximum(rms, 1e-3 * largest) if largest > 0 else np.ones(n)


def with_payload(model: Model, known: tuple[tuple[str, float], ...], name: str = "L") -> Model:
    """The model with a body on the flange; what is not given of it is guessed, without weight.

    The guess is a cube of `DENSITY` that stands on the flange's z axis, or about the centre of mass if that
    is given. It shows how much torque to expect, and never enters a fit.
    """
    given = dict(known)
    mass = given["M"]
    side = (mass / DENSITY) ** (1 / 3)
    inertia = mass * side**2 / 6
    if "MX" in given:
        centre = tuple(given[key] / mass for key in ("MX", "MY", "MZ"))
    else:
        centre = (0.0, 0.0, 0.5 * side)
    guess = dict(known_parameters(mass, centre, (inertia, 0.0, 0.0, inertia, 0.0, inertia)))
    stated = {f"{key}{name}": Prior(value) for key, value in guess.items() if key not in given}
    return replace(model + Payload(name, known), stated={**model.stated, **stated})
