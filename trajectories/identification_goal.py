"""The goal of identifying a model: from beliefs alone, or from what an earlier fit knows."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from exidyn.identify.base_parameters import BaseParameters, rich_motion
from exidyn.identify.effects import Belief, Payload
from exidyn.identify.errors import DifferentRobot
from exidyn.identify.fit import Fit
from exidyn.identify.model import Model
from exidyn.identify.robot import Limits

from .errors import NothingToIdentify, UnknownChoice
from .families.fourier import Fourier
from .search.criteria import CRITERIA, Criterion, Focus
from .search.goals import Identify
from .search.information import Experiment
from .search.payload_guess import with_payload
from .search.shrink import inside_kinematics
from .search.unknowns import with_drive_gains, with_shapes
from .wishes import Wishes, rows_of

NOISE = 0.01
"""Torque noise where none was measured, as a share of each joint's rms torque in a random motion: the
currents of industrial drives, at 500 Hz, scatter by one per cent."""


def identification_goal(model: Model, wishes: Wishes, limits: Limits) -> Identify:
    """To tell the model's parameters, and the drive gains where a pair of runs can."""
    if wishes.criterion not in CRITERIA:
        raise UnknownChoice("criterion", wishes.criterion, CRITERIA)
    payloads: tuple[str, ...] = ("",)
    believed = model
    if wishes.payload is not None:
        believed, payloads = with_payload(model, wishes.payload), ("", "L")
    if wishes.fit is not None:
        return _after(wishes.fit, believed, payloads, wishes)
    asked = with_shapes(believed, wishes.shapes)
    asked = with_drive_gains(asked) if wishes.payload is not None else asked
    experiment = Experiment.of(asked, payloads, believed_noise(believed, limits, payloads[-1]))
    criterion: Criterion = CRITERIA[wishes.criterion]
    if wishes.focus:
        criterion = focus(experiment.base, wishes.focus)
    return Identify(experiment, criterion, believed=believed)


def focus(base: BaseParameters, names: Sequence[str]) -> Focus:
    """Criterion for some base parameters; a name stands for all that begin with it.

    Raises:
        UnknownChoice: A name with which none begins.
    """
    for name in names:
        if not any(each.startswith(name) for each in base.names):
            raise UnknownChoice("base parameter", name, base.names)
    return Focus(tuple(k for k, each in enumerate(base.names) if each.startswith(tuple(names))))


def _after(fit: Fit, model: Model, payloads: tuple[str, ...], wishes: Wishes) -> Identify:
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
    bodies = {effect.name for effect in fit.model.effects if isinstance(effect, Payload)}
    if wishes.shapes or not set(payloads) <= {"", *bodies}:
        what = "shapes" if wishes.shapes else "a payload"
        raise NothingToIdentify(f"the fit knows nothing of {what}; plan for {what} without a fit")
    noise = np.maximum(fit.estimate.noise, np.finfo(float).tiny)
    base, told = _told(fit, payloads)
    known = np.linalg.pinv(fit.estimate.covariance[np.ix_(told, told)], hermitian=True)
    experiment = Experiment(learned(fit), base, payloads, noise, known)
    rows = rows_of(wishes, fit.filtering.torque_cutoff)
    criterion: Criterion = CRITERIA["worst" if wishes.criterion == "condition" else wishes.criterion]
    if wishes.focus:
        criterion = focus(base, wishes.focus)
    return Identify(experiment, criterion, rows)


def _told(fit: Fit, payloads: tuple[str, ...]) -> tuple[BaseParameters, np.ndarray]:
    """The base parameters that runs with these payloads move, and their places among those of the fit.

    Those of a body that no run carries stay as unsure as they are, whatever the motion.
    """
    regressors = [fit.model.regressor(rich_motion(fit.model, payload=payload)) for payload in payloads]
    told = np.flatnonzero(np.any(np.concatenate(regressors), axis=(0, 1))[fit.base.kept])
    return replace(fit.base, kept=fit.base.kept[told], regrouping=fit.base.regrouping[told]), told


def learned(fit: Fit) -> Model:
    """The model of a fit, believed as the fit found it: its torque, and sizes, are then the fitted ones."""
    believed, base = fit.model.believed_values, fit.base
    missing = fit.estimate.values - base.regrouping @ believed
    values = dict(zip(np.array(fit.model.names)[base.kept], believed[base.kept] + missing, strict=True))
    stds = dict(zip(values, fit.estimate.std, strict=True))
    stated = {str(name): Belief(float(value), float(stds[name])) for name, value in values.items()}
    return replace(fit.model, stated={**fit.model.stated, **stated})


def believed_noise(model: Model, limits: Limits, payload: str = "") -> np.ndarray:
    """Noise of each drive's torque where none was measured, shape (n,) [N m]; see `NOISE`."""
    n, random = model.robot.dof, np.random.default_rng(0)
    middle = 0.5 * (limits.position_lower + limits.position_upper)
    series = inside_kinematics(Fourier(10.0, middle, *random.normal(size=(2, n, 5))), limits, 0.9)
    motion = model.loaded(series.at(np.linspace(0.0, 10.0, 500)).motion(payload))
    on_motors = model.torque(motion, model.believed_values) @ model.robot.to_motors.T
    rms = np.sqrt(np.mean(on_motors**2, axis=0))
    largest = float(np.max(rms))
    return NOISE * np.maximum(rms, 1e-3 * largest) if largest > 0 else np.ones(n)
