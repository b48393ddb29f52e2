"""Goals of a plan: to identify a model, to add to an earlier fit, to distinguish two models."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np
from scipy.linalg import block_diag

from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import Payload, Prior, known_parameters
from exidyn.identification.errors import DifferentRobot, RobotError
from exidyn.identification.fit.base_parameters import BaseParameters, rich_motion
from exidyn.identification.fit.estimators.nominal_gains import given_nominal
from exidyn.identification.fit.fit import Fit
from exidyn.identification.model import Model

from ..discrimination.discriminate import Discriminate
from ..discrimination.separation import Hypothesis, Observation
from ..errors import NothingToIdentify, UnknownChoice
from ..families.fourier import Fourier
from ..search.criteria import CRITERIA, Criterion, Focus
from ..search.experiment import Experiment
from ..search.goals import Identify
from ..search.shrink import inside_kinematics
from ..search.unknowns import with_drive_gains, with_shapes
from ..trajectory import States
from .wanted import wanted_names
from .wishes import Wishes, rows_of

NOISE = 0.01
"""Torque noise where none was measured, as a share of each joint's rms torque in a random motion: the
currents of industrial drives, at 500 Hz, scatter by one per cent."""
DENSITY = 4000.0
"""Of a body on a flange [kg/m^3]: half of steel, since test weights are plates with gaps between them."""


def identification_goal(model: Model, wishes: Wishes, limits: Limits) -> Identify:
    """To identify the model's parameters, and the drive gains where a pair of runs can."""
    if wishes.criterion is not None and wishes.criterion not in CRITERIA:
        raise UnknownChoice("criterion", wishes.criterion, CRITERIA)
    nominal, payloads = with_bodies(model, wishes.bodies)
    if wishes.fit is not None:
        return after_fit(wishes.fit, nominal, payloads, wishes)
    asked = with_shapes(nominal, wishes.shapes)
    asked = with_drive_gains(asked) if wishes.bodies else asked
    experiment = Experiment.of(asked, payloads, nominal_noise(nominal, limits, payloads[-1]))
    return Identify(experiment, _criterion(experiment, wishes, "condition"), rows_of(wishes), nominal)


def _criterion(experiment: Experiment, wishes: Wishes, default: str) -> Criterion:
    """The criterion of what the user wants to know."""
    if not wishes.in_focus:
        return CRITERIA[wishes.criterion or default]
    names, robot = experiment.base.names, experiment.model.robot
    return Focus.on(names, wanted_names(wishes.in_focus, names, robot.joints, experiment.payloads))


def nominal_noise(model: Model, limits: Limits, payload: str = "") -> np.ndarray:
    """Noise of each drive's torque where none was measured, shape (n,) [N m]; see `NOISE`."""
    motion = model.loaded(typical_states(limits).motion(payload))
    on_motors = model.torque(motion, model.nominal_values) @ model.robot.to_motors.T
    rms = np.sqrt(np.mean(on_motors**2, axis=0))
    largest = float(np.max(rms))
    return NOISE * np.maximum(rms, 1e-3 * largest) if largest > 0 else np.ones(model.robot.dof)


def typical_states(limits: Limits) -> States:
    """A random motion of all joints through most of the kinematic limits, ten seconds long."""
    random = np.random.default_rng(0)
    middle = 0.5 * (limits.position_lower + limits.position_upper)
    coefficients = random.normal(size=(2, len(middle), 5))
    series = inside_kinematics(Fourier(10.0, middle, *coefficients), limits, 0.9)
    return series.at(np.linspace(0.0, 10.0, 500))


def with_bodies(
    model: Model, bodies: Sequence[tuple[tuple[str, float], ...]]
) -> tuple[Model, tuple[str, ...]]:
    """The model with bodies on the flange, one a run, and the names of the runs: first the unloaded one."""
    names = [f"L{place}" for place in range(1, len(bodies) + 1)] if len(bodies) > 1 else ["L"] * len(bodies)
    for name, known in zip(names, bodies, strict=True):
        model = with_payload(model, known, name)
    return model, ("", *names)


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


def after_fit(fit: Fit, model: Model, payloads: tuple[str, ...], wishes: Wishes) -> Identify:
    """To add to what a fit knows already, where it knows least.

    Raises:
        DifferentRobot: A fit of another arm.
        NothingToIdentify: A payload or shapes of which the fit knows nothing.
    """
    if fit.model.robot.joints != model.robot.joints:
        raise DifferentRobot(
            f"the fit is of {fit.model.robot.name} (joints {', '.join(fit.model.robot.joints)}), and the "
            f"robot is {model.robot.name} (joints {', '.join(model.robot.joints)}); give the fit of this one"
        )
    if wishes.shapes or not set(payloads) <= {"", *fit.model.payloads}:
        what = "shapes" if wishes.shapes else "a payload"
        raise NothingToIdentify(f"the fit knows nothing of {what}; plan for {what} without a fit")
    noise = np.maximum(fit.estimate.noise, np.finfo(float).tiny)
    gains_found = bool(np.all(fit.estimate.gain_estimated))  # then they too are known only so well
    experiment = (_with_gains if gains_found else _values)(fit, payloads, noise)
    criterion = _criterion(experiment, wishes, "worst")
    return Identify(experiment, criterion, rows_of(wishes, fit.filtering.torque_cutoff), learned(fit))


def _values(fit: Fit, payloads: tuple[str, ...], noise: np.ndarray) -> Experiment:
    """What the fit knows of its base parameters, its gains taken as exact."""
    base, visible = _visible(fit, payloads)
    covariance = given_nominal(fit.estimate)[np.ix_(visible, visible)]
    return Experiment(learned(fit), base, payloads, noise, _precision(covariance))


def _with_gains(fit: Fit, payloads: tuple[str, ...], noise: np.ndarray) -> Experiment:
    """The same with the gains unknown, as far as the fit left them so.

    A column of `DriveGains` is the torque that is missing if a gain is too small, so a gain's relative
    error counts with a minus.
    """
    model = with_drive_gains(learned(fit))
    (base, visible), gain, count = _visible(fit, payloads), fit.estimate.gain, len(fit.base.kept)
    places = np.concatenate([visible, count + np.arange(len(gain))])
    scale = np.concatenate([np.ones(len(visible)), -1.0 / gain])
    covariance = fit.estimate.covariance[np.ix_(places, places)] * np.outer(scale, scale)
    extended = BaseParameters(
        tuple(model.parameters),
        np.concatenate([base.kept, len(base.parameters) + np.arange(len(gain))]),
        block_diag(base.regrouping, np.eye(len(gain))),
        base.gap,
    )
    return Experiment(model, extended, payloads, noise, _precision(covariance))


def _precision(covariance: np.ndarray) -> np.ndarray:
    """Inverse of a covariance, by way of correlations, since newtons and radians differ by decades."""
    std = np.sqrt(np.diag(covariance))
    return np.asarray(np.linalg.pinv(covariance / np.outer(std, std), hermitian=True) / np.outer(std, std))


def _visible(fit: Fit, payloads: tuple[str, ...]) -> tuple[BaseParameters, np.ndarray]:
    """The base parameters that runs with these payloads move, and their places among those of the fit.

    Those of a body that no run carries stay as unsure as they are, whatever the motion.
    """
    regressors = [fit.model.regressor(rich_motion(fit.model, payload=payload)) for payload in payloads]
    visible = np.flatnonzero(np.any(np.concatenate(regressors), axis=(0, 1))[fit.base.kept])
    return replace(fit.base, kept=fit.base.kept[visible], regrouping=fit.base.regrouping[visible]), visible


def learned(fit: Fit) -> Model:
    """The model of a fit, nominal as the fit found it: its torque, and sizes, are then the fitted ones."""
    nominal, base = fit.model.nominal_values, fit.base
    missing = fit.estimate.values - base.regrouping @ nominal
    values = dict(zip(np.array(fit.model.names)[base.kept], nominal[base.kept] + missing, strict=True))
    stds = dict(zip(values, fit.estimate.std, strict=True))
    stated = {str(name): Prior(float(value), float(stds[name])) for name, value in values.items()}
    return replace(fit.model, stated={**fit.model.stated, **stated})


def two_models(models: Sequence[Model], names: Sequence[str], limits: Limits, rows: float) -> Discriminate:
    """The goal.

    Args:
        models: Each with one explanation and the values of its effects; the first gives the noise.
        names: What people call them.
        limits: Within which the arm moves.
        rows: Independent rows of the run.

    Raises:
        RobotError: What one model has beyond the other has no values, and so explains nothing.
    """
    hypotheses = tuple(Hypothesis.of_priors(name, one) for name, one in zip(names, models, strict=True))
    for hypothesis, other in permutations(hypotheses):
        _require_values(hypothesis, other)
    return Discriminate(hypotheses, Observation(nominal_noise(models[0], limits), rows))


def _require_values(one: Hypothesis, other: Hypothesis) -> None:
    known = set(other.model.names)
    own = {n: v for n, v in zip(one.model.names, one.values, strict=True) if n not in known}
    if own and not any(own.values()):
        raise RobotError(
            f"{one.name}: {', '.join(own)} have no values, so it is the same as {other.name}. Give its "
            "effects the values that a fit found: values = [...] in their [[effect]] rows"
        )
