"""The model that a fit found: one standard value for each parameter, with bodies that can exist.

A fit has base parameters, the combinations that torque can distinguish; simulators want mass and moments of
every link. Of all standard parameters that agree with the fit the most probable are taken, by what was
nominal, among those that are physically consistent. Nominal values fill in what the data leave open and do
not overrule them: they are held so loosely that they draw no value beyond its own 95 %. Only consistency may
move one farther; such values are in `Fit.moved`. Drive gains and values go together: where a gain is open,
values are those that go with the one that is taken.
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
from .estimators.nominal_gains import given_nominal
from .fit import Fit
from .settled_gains import Settled, settled
from .verdict import gains_estimated

WITHOUT_PRIOR = 1e3
"""Deviation of what has no prior, over the size of what was identified: so wide that it
draws to zero by a millionth of one deviation of the fit at most."""
HELD = 1e-9
"""Smallest deviation over the same size: what is zero for certain stays there."""
WIDEST = 1e6
"""Largest over the same size: a stated deviation of more is none, and rounding grows with it."""
TINY = 1e-3
"""Smallest size, over the usual one, that a base parameter is taken to have where its value is near zero."""
UNSEEN = 0.5
"""Share of its deviation that a parameter keeps of which the data show nothing; what they show of others
leaves a thousandth, see `WITHOUT_PRIOR`."""
LOOSEST = 2.0**10
"""Factor on the tolerance of nominal values up to which they are widened: beyond it they have no effect."""
SAME = 1e-9
"""Share up to which standard parameters give the same as base parameters: rounding."""


class Standard(NamedTuple):
    """Standard parameters of a fit.

    Attributes:
        values: Those of an arm that can exist, shape (p,).
        covariance: What data and nominal values leave open, shape (p, p); a variance is infinite where
            neither tells anything.
    """

    values: np.ndarray
    covariance: np.ndarray


def identified(fit: Fit) -> Model:
    """The fit's model, what was identified as its priors: `nominal_values` and drive gains are the fit's.

    Raises:
        FitError: The fit's torques are currents, or no arm that can exist is near it.
    """
    found = standard_parameters(fit)
    return _stating(fit, settled(fit), found.values, np.sqrt(np.diag(found.covariance)))


def standard_parameters(fit: Fit) -> Standard:
    """The parameters of `identified`, and how they vary together.

    Raises:
        FitError: As of `identified`.
    """
    if fit.unscaled:
        raise FitError(
            f"{fit.model.robot.name}: what the fit calls torque is current, and its masses are no masses. "
            "State drive gains in the robot file, or identify them with a known payload, then fit again"
        )
    model, found = fit.model, settled(fit)
    base, values, given = _structure(fit, found.values, found.given)
    held = _held(fit, base, values, given)
    standard, size = fit.estimate.standard, np.abs(values).max()
    if (
        fit.estimate.method != "consistent"
        or standard is None
        or not np.allclose(base.regrouping @ standard, values, rtol=SAME, atol=SAME * size)
    ):
        standard = nearest(held, values, given)
    # What the data show of standard parameters, in units of their tolerance.
    whiten = whitening(held, values, given)
    rows = whiten @ base.regrouping * held.tolerance
    left = after_unit_prior(rows)
    by_gain = held.tolerance[:, None] * (left @ (rows.T @ (whiten @ _in_structure(fit, found.by_gain))))
    covariance = held.tolerance[:, None] * left * held.tolerance + by_gain @ found.gain_covariance @ by_gain.T
    # What neither the data nor anybody knows stays unknown.
    open_ = np.sqrt(np.diag(left)) > UNSEEN
    unknown = np.flatnonzero(open_ & np.isinf([prior.std for prior in model.priors]))
    covariance[unknown, unknown] = np.inf
    return Standard(standard, covariance)


def exported(fit: Fit) -> np.ndarray | None:
    """Base values (b,) that export and simulation take, those of `identified`; None where it takes none."""
    try:
        return fit.base.regrouping @ identified(fit).nominal_values
    except FitError:
        return None


def _held(fit: Fit, base: BaseParameters, values: np.ndarray, covariance: np.ndarray) -> Held:
    """Nominal values, held so loosely that they draw no kept value beyond its own 95 %."""
    kept = [base.names.index(name) for name in _structural_names(fit)]
    std, loose = np.sqrt(np.diag(given_nominal(fit.estimate))), 1.0
    while True:
        tolerance = _tolerance(fit, base, values, loose)
        held = Held(base, fit.model.nominal_values, tolerance, tuple(fit.model.inertias))
        moved = base.regrouping[kept] @ unconstrained(held, values, covariance)[0] - values[kept]
        if loose >= LOOSEST or np.all(np.abs(moved) <= NORMAL_95 * std):
            return held
        loose *= 2.0


def _structure(
    fit: Fit, found: np.ndarray, covariance_found: np.ndarray
) -> tuple[BaseParameters, np.ndarray, np.ndarray]:
    """All base parameters, their values (b,) and covariance (b, b), from those of the kept ones.

    Those that were dropped are zero, up to what they would have been: the data do not show more of them.
    """
    base = fit.structure or fit.base
    covariance = _in_structure(fit, _in_structure(fit, covariance_found).T)
    for row, name in enumerate(base.names):
        covariance[row, row] += fit.dropped.get(name, 0.0) ** 2
    return base, _in_structure(fit, found), covariance


def _in_structure(fit: Fit, kept: np.ndarray) -> np.ndarray:
    """Rows of the kept base parameters among those of all, zero for what was dropped."""
    base = fit.structure or fit.base
    rows = np.zeros((len(base.names), *kept.shape[1:]))
    rows[[base.names.index(name) for name in _structural_names(fit)]] = kept
    return rows


def _structural_names(fit: Fit) -> list[str]:
    """Names of the kept base parameters as the whole structure has them."""
    base = fit.structure or fit.base
    by_column = dict(zip(base.kept, base.names, strict=True))
    return [by_column[column] for column in fit.base.kept]


def _tolerance(fit: Fit, base: BaseParameters, values: np.ndarray, loose: float) -> np.ndarray:
    """Deviation of each standard parameter before the data, shape (p,), finite and above zero.

    Stated ones are `loose` times as wide.
    """
    std, weight = np.array([prior.std for prior in fit.model.priors]), np.abs(base.regrouping)
    usual = float(np.median(np.abs(values[values != 0.0]))) if np.any(values) else 1.0
    size = np.maximum(np.abs(values), TINY * usual)[:, None]
    scale = np.divide(size, weight, out=np.zeros_like(weight), where=weight > 0.0).max(axis=0)
    scale = np.where(scale > 0.0, scale, usual)  # in no base parameter: nothing of it is seen
    stated = np.clip(loose * std, HELD * scale, WIDEST * scale)
    return np.where(np.isfinite(std), stated, WITHOUT_PRIOR * scale)


def _stating(fit: Fit, found: Settled, standard: np.ndarray, deviation: np.ndarray) -> Model:
    """The model with these as its priors: bodies in the robot, where it has them, all else stated."""
    model, robot, stated = fit.model, fit.model.robot, dict[str, Prior]()
    if fit.measures == "current":
        robot = replace(robot, drive_gain=found.gain, inertias_by_gain=True)
    if fit.measures == "current" and gains_estimated(fit):
        tolerance = np.sqrt(np.diag(found.gain_covariance)) / np.abs(found.gain)
        robot = replace(robot, drive_gain_tolerance=tolerance)
    for effect, own in zip(model.effects, model.columns, strict=True):
        if effect.of_links:
            robot = with_bodies(robot, standard[own].reshape(robot.dof, 10))
            continue
        priors = zip(map(float, standard[own]), map(float, deviation[own]), strict=True)
        stated |= {name: Prior(*one) for name, one in zip(model.names[own], priors, strict=True)}
    return Model(robot, model.effects, stated, measurements=model.measurements)
