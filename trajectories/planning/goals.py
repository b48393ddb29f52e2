"""Goals of a plan, and room below the torque limits for the uncertainty of an arm's parameters.

A goal is to identify a model, to improve an earlier fit, or to distinguish two models.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np
from scipy.linalg import block_diag

from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import Payload, Prior, known_parameters
from exidyn.identification.errors import DifferentRobot, FitError, RobotError
from exidyn.identification.fit.base_parameters import BaseParameters, rich_motion
from exidyn.identification.fit.estimators.least_squares import given_nominal
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identified import standard_parameters
from exidyn.identification.model import Model

from ..discrimination.discriminate import Discriminate
from ..discrimination.separation import Hypothesis, Observation
from ..errors import NothingToIdentify, UnknownChoice
from ..families.fourier import Fourier
from ..search.criteria import CRITERIA, Criterion, Focus
from ..search.experiment import Experiment, loaded_runs
from ..search.goals import Identify
from ..search.shrink import inside_kinematics
from ..search.torque_spread import TorqueSpread, spread_of
from ..search.unknowns import with_drive_gains, with_shapes
from ..trajectory import States
from .wishes import Wishes, rows_of, wanted_names

NOISE = 0.01
"""Torque noise if none was measured, as a share of each joint's rms torque in a random motion: the currents
of industrial drives scatter by 1 % at 500 Hz."""
DENSITY = 4000.0
"""Density of a payload [kg/m^3]: half that of steel, since test weights are plates with gaps between them."""


def identification_goal(model: Model, wishes: Wishes, limits: Limits) -> Identify:
    """The goal to identify the model's parameters, and the drive gains if there are runs with payloads."""
    if wishes.criterion is not None and wishes.criterion not in CRITERIA:
        raise UnknownChoice("criterion", wishes.criterion, CRITERIA)
    nominal, payloads = with_bodies(model, wishes.bodies)
    if wishes.fit is not None:
        return after_fit(wishes.fit, nominal, payloads, wishes)
    extended = with_shapes(nominal, wishes.shapes)
    extended = with_drive_gains(extended) if wishes.bodies else extended
    experiment = Experiment.of(extended, payloads, nominal_noise(nominal, limits, payloads[-1]))
    return Identify(experiment, _criterion(experiment, wishes, "condition"), rows_of(wishes), nominal)


def _criterion(experiment: Experiment, wishes: Wishes, default: str) -> Criterion:
    """The criterion that the planning options select."""
    if not wishes.in_focus:
        return CRITERIA[wishes.criterion or default]
    names, robot = experiment.base.names, experiment.model.robot
    wanted = tuple(wanted_names(wishes.in_focus, names, robot.joints, experiment.payloads))
    return Focus(tuple(k for k, name in enumerate(names) if name.startswith(wanted)))


def nominal_noise(model: Model, limits: Limits, payload: str = "") -> np.ndarray:
    """Assumed noise of each drive's torque, shape (n,) [N m]; see `NOISE`."""
    motion = model.loaded(typical_states(limits).motion(payload))
    on_motors = model.torque(motion, model.nominal_values) @ model.robot.to_motors.T
    rms = np.sqrt(np.mean(on_motors**2, axis=0))
    largest = float(np.max(rms))
    return NOISE * np.maximum(rms, 1e-3 * largest) if largest > 0 else np.ones(model.robot.dof)


def typical_states(limits: Limits) -> States:
    """A random motion of all joints of ten seconds that uses most of the kinematic limits."""
    random = np.random.default_rng(0)
    middle = 0.5 * (limits.position_lower + limits.position_upper)
    coefficients = random.normal(size=(2, len(middle), 5))
    series = inside_kinematics(Fourier(10.0, middle, *coefficients), limits, 0.9)
    return series.at(np.linspace(0.0, 10.0, 500))


def with_bodies(
    model: Model, bodies: Sequence[tuple[tuple[str, float], ...]]
) -> tuple[Model, tuple[str, ...]]:
    """The model with payloads, and the payload of each run: first the unloaded run, then one per payload."""
    names = [f"L{place}" for place in range(1, len(bodies) + 1)] if len(bodies) > 1 else ["L"] * len(bodies)
    for name, known in zip(names, bodies, strict=True):
        model = with_payload(model, known, name)
    return model, ("", *names)


def with_payload(model: Model, known: tuple[tuple[str, float], ...], name: str = "L") -> Model:
    """The model with a payload; its unknown parameters are guessed, with infinite prior standard deviation.

    The guess is a cube of `DENSITY` on the flange's z axis, or about the center of mass if that is known. It
    gives the expected torque, and never enters a fit.
    """
    known_values = dict(known)
    mass = known_values["M"]
    side = (mass / DENSITY) ** (1 / 3)
    inertia = mass * side**2 / 6
    if "MX" in known_values:
        center = tuple(known_values[key] / mass for key in ("MX", "MY", "MZ"))
    else:
        center = (0.0, 0.0, 0.5 * side)
    guess = dict(known_parameters(mass, center, (inertia, 0.0, 0.0, inertia, 0.0, inertia)))
    stated = {f"{key}{name}": Prior(value) for key, value in guess.items() if key not in known_values}
    return replace(model + Payload(name, known), stated={**model.stated, **stated})


def after_fit(fit: Fit, model: Model, payloads: tuple[str, ...], wishes: Wishes) -> Identify:
    """The goal to add information to a fit where its estimates are least certain.

    Raises:
        DifferentRobot: The fit is of another arm.
        NothingToIdentify: The fit does not contain a payload, or shapes are requested.
    """
    if fit.model.robot.joints != model.robot.joints:
        raise DifferentRobot(
            f"the fit is of {fit.model.robot.name} (joints {', '.join(fit.model.robot.joints)}), and the "
            f"robot is {model.robot.name} (joints {', '.join(model.robot.joints)}). Use a fit of this robot"
        )
    if wishes.shapes or not set(payloads) <= {"", *fit.model.payloads}:
        missing = "shapes" if wishes.shapes else "a payload"
        raise NothingToIdentify(f"the fit has no information on {missing}. Plan for {missing} without a fit")
    noise = np.maximum(fit.estimate.noise, np.finfo(float).tiny)
    gains_estimated = bool(np.all(fit.estimate.gain_estimated))  # then the gains are uncertain too
    experiment = (_with_gains if gains_estimated else _values)(fit, payloads, noise)
    criterion = _criterion(experiment, wishes, "worst")
    return Identify(experiment, criterion, rows_of(wishes, fit.filtering.torque_cutoff), learned(fit))


def _values(fit: Fit, payloads: tuple[str, ...], noise: np.ndarray) -> Experiment:
    """The fit's information on its base parameters, with exact gains."""
    base, visible = _visible(fit, payloads)
    covariance = given_nominal(fit.estimate)[np.ix_(visible, visible)]
    return Experiment(learned(fit), base, payloads, noise, _precision(covariance))


def _with_gains(fit: Fit, payloads: tuple[str, ...], noise: np.ndarray) -> Experiment:
    """The fit's information on its base parameters and drive gains.

    A column of `DriveGains` is the torque that is missing if a gain is too small, so a gain's relative error
    has a negative sign.
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
    """Inverse of a covariance, computed from correlations, since parameter units differ by decades."""
    std = np.sqrt(np.diag(covariance))
    return np.asarray(np.linalg.pinv(covariance / np.outer(std, std), hermitian=True) / np.outer(std, std))


def _visible(fit: Fit, payloads: tuple[str, ...]) -> tuple[BaseParameters, np.ndarray]:
    """The base parameters that act in runs with these payloads, and their indices among those of the fit.

    No motion reduces the uncertainty of the parameters of a payload that no run carries.
    """
    regressors = [fit.model.regressor(rich_motion(fit.model, payload=payload)) for payload in payloads]
    visible = np.flatnonzero(np.any(np.concatenate(regressors), axis=(0, 1))[fit.base.kept])
    return replace(fit.base, kept=fit.base.kept[visible], regrouping=fit.base.regrouping[visible]), visible


def learned(fit: Fit) -> Model:
    """The model of a fit with the estimates as nominal values, so that its torque is the fitted one."""
    nominal, base = fit.model.nominal_values, fit.base
    missing = fit.estimate.values - base.regrouping @ nominal
    values = dict(zip(np.array(fit.model.names)[base.kept], nominal[base.kept] + missing, strict=True))
    stds = dict(zip(values, fit.estimate.std, strict=True))
    stated = {str(name): Prior(float(value), float(stds[name])) for name, value in values.items()}
    return replace(fit.model, stated={**fit.model.stated, **stated})


def two_models(models: Sequence[Model], names: Sequence[str], limits: Limits, rows: float) -> Discriminate:
    """The goal to distinguish models.

    Each has one explanation with the values of its effects; the first gives the noise.

    Raises:
        RobotError: The parameters that one model has beyond another have no values, so it explains nothing.
    """
    hypotheses = tuple(Hypothesis.of_priors(name, model) for name, model in zip(names, models, strict=True))
    for hypothesis, other in permutations(hypotheses):
        _require_values(hypothesis, other)
    return Discriminate(hypotheses, Observation(nominal_noise(models[0], limits), rows))


def _require_values(hypothesis: Hypothesis, other: Hypothesis) -> None:
    shared = set(other.model.names)
    values = zip(hypothesis.model.names, hypothesis.values, strict=True)
    additional = {name: value for name, value in values if name not in shared}
    if additional and not any(additional.values()):
        raise RobotError(
            f"{hypothesis.name}: {', '.join(additional)} have no values, so it equals {other.name}. Set the "
            "values of its effects from a fit: values = [...] in their [[effect]] rows"
        )


def torque_spread(
    model: Model, limits: Limits, payloads: Sequence[str], sure: float, fit: Fit | None = None
) -> TorqueSpread | None:
    """Uncertainty of the torque; None if no parameter is uncertain, or no torque is limited.

    `sure` is the share of possible arms that must keep to the limits. The estimates of a fit replace the
    priors, and its residual counts as uncertainty.
    """
    if not sure or not np.any(np.isfinite(limits.torque)):
        return None
    runs = loaded_runs(model, typical_states(limits).motion(), payloads)
    columns = np.concatenate([model.regressor(run) for run in runs])
    covariance = _prior_covariance(model)
    residual = np.zeros(model.robot.dof)
    if fit is not None:
        covariance, residual = _fit_covariance(fit, model), np.abs(fit.estimate.noise)
    return spread_of(covariance, sure, residual, columns)


def _prior_covariance(model: Model) -> np.ndarray:
    """Covariance of the model's parameters from its priors, shape (p, p)."""
    return np.diag(np.square([prior.std for prior in model.priors]))


def _fit_covariance(fit: Fit, model: Model) -> np.ndarray:
    """Covariance of the model's parameters from a fit, and from priors for payloads that no run carried."""
    covariance = _prior_covariance(model)
    try:
        fitted = standard_parameters(fit).covariance
    except FitError:  # torques are currents: use the covariance of the base parameters
        base_columns = fit.base.kept
        count = len(base_columns)
        fitted = np.zeros((len(fit.model.names),) * 2)
        fitted[np.ix_(base_columns, base_columns)] = fit.estimate.covariance[:count, :count]
    places = [model.names.index(name) for name in fit.model.names if name in model.names]
    fit_places = [k for k, name in enumerate(fit.model.names) if name in model.names]
    covariance[np.ix_(places, places)] = fitted[np.ix_(fit_places, fit_places)]
    return covariance
