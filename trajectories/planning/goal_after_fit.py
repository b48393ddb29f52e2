"""The goal of adding to what an earlier fit knows, where it knows least."""

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from exidyn.identify.effects import Prior
from exidyn.identify.errors import DifferentRobot
from exidyn.identify.fit.base_parameters import BaseParameters, rich_motion
from exidyn.identify.fit.fit import Fit
from exidyn.identify.model import Model

from ..errors import NothingToIdentify
from ..search.information.criteria import CRITERIA, Criterion, Focus
from ..search.information.experiment import Experiment
from ..search.information.goals import Identify
from ..search.information.unknowns import with_drive_gains
from .wishes import Wishes, rows_of


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
    gains_found = bool(np.all(fit.estimate.gain_std > 0.0))  # then they too are known only so well
    experiment = (_with_gains if gains_found else _values)(fit, payloads, noise)
    criterion: Criterion = CRITERIA["worst" if wishes.criterion == "condition" else wishes.criterion]
    if wishes.focus:
        criterion = Focus.on(experiment.base.names, wishes.focus)
    return Identify(experiment, criterion, rows_of(wishes, fit.filtering.torque_cutoff), learned(fit))


def _values(fit: Fit, payloads: tuple[str, ...], noise: np.ndarray) -> Experiment:
    """What the fit knows of its base parameters, its gains taken as exact."""
    base, visible = _visible(fit, payloads)
    covariance = fit.estimate.covariance[np.ix_(visible, visible)]
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
