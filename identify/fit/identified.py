"""The identified model: a value for each standard parameter, with physically consistent bodies.

A fit determines base parameters, the combinations that torque can distinguish; simulators need mass and
moments of every link. The model has the most probable standard parameters, by the nominal values, that agree
with the fit and are physically consistent. Nominal values fill in what the data do not determine and do not
overrule them: their tolerance is widened until neither they nor the step from them to consistent bodies move
a base value outside its 95 % interval. If no tolerance suffices, the fit itself is inconsistent, and
`Fit.moved` lists the values. Base values depend on the drive gains: if
a gain is open, the values are those at the gain of the model.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..effects import Prior
from ..effects.rigid_body import with_bodies
from ..errors import FitError
from ..model import Model
from ..positive_definite import after_unit_prior
from ..text_table import NORMAL_95
from .base_parameters import BaseParameters
from .estimators.consistent import Held, nearest, unconstrained, whitening
from .estimators.least_squares import given_nominal
from .fit import Fit
from .settled_gains import Settled, settled
from .verdict import gains_estimated

WITHOUT_PRIOR = 1e3
"""Standard deviation of a parameter without a prior, over the size of the identified values: so wide that it
moves a value toward zero by at most a millionth of its standard deviation in the fit."""
HELD = 1e-9
"""Smallest standard deviation, over the same size: a parameter that is certainly zero stays zero."""
WIDEST = 1e6
"""Largest standard deviation, over the same size: wider ones have no effect and increase rounding errors."""
TINY = 1e-3
"""Minimum size of a base parameter with a value near zero, over the median size."""
UNSEEN = 0.5
"""A parameter that keeps more than this share of its prior deviation was not observed; parameters that the
data show keep about a thousandth, see `WITHOUT_PRIOR`."""
LOOSER = 4.0 ** np.arange(11)
"""Factors by which tolerances of nominal values are widened: beyond a million, they have no effect."""
CLOSER = 0.95
"""A wider prior must bring the farthest value nearer by this factor; otherwise the prior is not the cause."""
SAME = 1e-9
"""Relative difference between standard and base parameters that counts as rounding."""


class Standard(NamedTuple):
    """Standard parameters of a fit."""

    values: np.ndarray  # physically consistent values, shape (p,)
    # Covariance given data and nominal values, shape (p, p); a variance is infinite if neither determines the
    # parameter.
    covariance: np.ndarray


def identified(fit: Fit, standard: Standard | None = None) -> Model:
    """Model whose nominal values, priors and drive gains are those identified by the fit.

    Raises:
        FitError: Drive gains are unknown, or there are no physically consistent parameters near the fit.
    """
    standard = standard or standard_parameters(fit)
    return _with_priors(fit, settled(fit), standard.values, np.sqrt(np.diag(standard.covariance)))


def standard_parameters(fit: Fit) -> Standard:
    """Standard parameters of the identified model, with their covariance.

    Raises:
        FitError: See `identified`.
    """
    if fit.unscaled:
        raise FitError(
            f"{fit.model.robot.name}: drive gains are unknown, so torques are in amperes and masses are not "
            "in kilograms. State drive gains in the robot file, or identify them with a known payload, then "
            "fit again"
        )
    model, gains = fit.model, settled(fit)
    base, values, conditional = _structure(fit, gains.values, gains.conditional)
    held, nearest_values = _held(fit, base, values, conditional)
    standard, size = fit.estimate.standard, np.abs(values).max()
    if (
        fit.estimate.method != "consistent"
        or standard is None
        or not np.allclose(base.regrouping @ standard, values, rtol=SAME, atol=SAME * size)
    ):
        standard = nearest_values
    # Information of the data on standard parameters, in units of their tolerance
    whiten = whitening(held, values, conditional)
    rows = whiten @ base.regrouping * held.tolerance
    posterior = after_unit_prior(rows)
    by_gain = held.tolerance[:, None] * (posterior @ (rows.T @ (whiten @ _in_structure(fit, gains.by_gain))))
    covariance = held.tolerance[:, None] * posterior * held.tolerance
    covariance = covariance + by_gain @ gains.gain_covariance @ by_gain.T
    # A parameter that neither the data nor a prior determines stays unknown.
    unseen = np.sqrt(np.diag(posterior)) > UNSEEN
    unknown = np.flatnonzero(unseen & np.isinf([prior.std for prior in model.priors]))
    covariance[unknown, unknown] = np.inf
    return Standard(standard, covariance)


def exported(fit: Fit) -> np.ndarray | None:
    """Base values (b,) of the identified model, for export and simulation; None if there is no such model."""
    try:
        return fit.base.regrouping @ identified(fit).nominal_values
    except FitError:
        return None


def _held(
    fit: Fit, base: BaseParameters, values: np.ndarray, covariance: np.ndarray
) -> tuple[Held, np.ndarray]:
    """Prior from the nominal values, wide enough to leave values in their intervals; nearest parameters (p,).

    If no prior is wide enough, it is the one that moves the farthest value least.
    """
    rows = [base.names.index(name) for name in _structural_names(fit)]
    std = np.maximum(np.sqrt(np.diag(given_nominal(fit.estimate))), np.finfo(float).tiny)

    def farthest(standard: np.ndarray) -> float:
        return float(np.max(np.abs(base.regrouping[rows] @ standard - values[rows]) / std, initial=0.0))

    trials: list[tuple[float, Held, np.ndarray]] = []
    for loose in LOOSER:
        tolerance = _tolerance(fit, base, values, loose)
        held = Held(base, fit.model.prior_values, tolerance, tuple(fit.model.inertias))
        if loose < LOOSER[-1] and farthest(unconstrained(held, values, covariance)[0]) > NORMAL_95:
            continue  # the constraints would move the values even farther
        standard = nearest(held, values, covariance)
        trials.append((farthest(standard), held, standard))
        distances = [distance for distance, *_ in trials]
        if distances[-1] <= NORMAL_95 or distances[-1] > CLOSER * min(distances[:-1], default=np.inf):
            break
    _, held, standard = min(trials, key=lambda trial: trial[0])
    return held, standard


def _structure(
    fit: Fit, fit_values: np.ndarray, fit_covariance: np.ndarray
) -> tuple[BaseParameters, np.ndarray, np.ndarray]:
    """All structural base parameters, their values (b,) and covariance (b, b), from those of the fit.

    Dropped parameters are zero; their standard deviation is the value that was dropped.
    """
    base = fit.structure or fit.base
    covariance = _in_structure(fit, _in_structure(fit, fit_covariance).T)
    for row, name in enumerate(base.names):
        covariance[row, row] += fit.dropped.get(name, 0.0) ** 2
    return base, _in_structure(fit, fit_values), covariance


def _in_structure(fit: Fit, fit_rows: np.ndarray) -> np.ndarray:
    """Rows of the fit's base parameters placed among those of the structure, with zeros for dropped ones."""
    base = fit.structure or fit.base
    rows = np.zeros((len(base.names), *fit_rows.shape[1:]))
    rows[[base.names.index(name) for name in _structural_names(fit)]] = fit_rows
    return rows


def _structural_names(fit: Fit) -> list[str]:
    """Names of the fit's base parameters in the structure before parameters were dropped."""
    base = fit.structure or fit.base
    by_column = dict(zip(base.kept, base.names, strict=True))
    return [by_column[column] for column in fit.base.kept]


def _tolerance(fit: Fit, base: BaseParameters, values: np.ndarray, loose: float) -> np.ndarray:
    """Prior standard deviation of each standard parameter, shape (p,), finite and above zero.

    Stated standard deviations are widened by the factor `loose`.
    """
    std, weight = np.array([prior.std for prior in fit.model.priors]), np.abs(base.regrouping)
    usual = float(np.median(np.abs(values[values != 0.0]))) if np.any(values) else 1.0
    size = np.maximum(np.abs(values), TINY * usual)[:, None]
    scale = np.divide(size, weight, out=np.zeros_like(weight), where=weight > 0.0).max(axis=0)
    scale = np.where(scale > 0.0, scale, usual)  # parameters that are in no base parameter
    stated = np.clip(loose * std, HELD * scale, WIDEST * scale)
    return np.where(np.isfinite(std), stated, WITHOUT_PRIOR * scale)


def _with_priors(fit: Fit, gains: Settled, standard: np.ndarray, deviation: np.ndarray) -> Model:
    """Model with these values as priors: bodies of links in the robot, all others as stated parameters."""
    model, robot, stated = fit.model, fit.model.robot, dict[str, Prior]()
    if fit.measures == "current":
        robot = replace(robot, drive_gain=gains.gain, inertias_by_gain=True)
    if fit.measures == "current" and gains_estimated(fit):
        tolerance = np.sqrt(np.diag(gains.gain_covariance)) / np.abs(gains.gain)
        robot = replace(robot, drive_gain_tolerance=tolerance)
    for effect, columns in zip(model.effects, model.columns, strict=True):
        if effect.of_links:
            robot = with_bodies(robot, standard[columns].reshape(robot.dof, 10))
            continue
        priors = zip(map(float, standard[columns]), map(float, deviation[columns]), strict=True)
        stated |= {name: Prior(*pair) for name, pair in zip(model.names[columns], priors, strict=True)}
    return Model(robot, model.effects, stated, measurements=model.measurements)
