"""The model that a fit found: one standard value for each parameter, with bodies that can exist.

A fit has base parameters, the combinations that torque can distinguish; simulators want mass and moments of
every link. Of all standard parameters that agree with the fit the most probable are taken, by what was
nominal, among those that are physically consistent.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ..arm.robot import Robot
from ..effects import Prior, RigidBody
from ..effects.rigid_body import body_inertia
from ..errors import FitError
from ..model import Model
from .base_parameters import BaseParameters
from .estimators.consistent import Held, nearest, whitening
from .fit import Fit

WITHOUT_PRIOR = 1e3
"""Deviation of what has no prior, over the size of what was identified: so wide that it
draws to zero by a millionth of one deviation of the fit at most."""
HELD = 1e-9
"""Smallest deviation over the same size: what is zero for certain stays there."""
TINY = 1e-3
"""Smallest size, over the usual one, that a base parameter is taken to have where its value is near zero."""
UNSEEN = 0.5
"""Share of its deviation that a parameter keeps of which the data show nothing; what they show of others
leaves a thousandth, see `WITHOUT_PRIOR`."""
SAME = 1e-9
"""Share up to which standard parameters give the same as base parameters: rounding."""


def identified(fit: Fit) -> Model:
    """The fit's model, what was identified as its priors: `nominal_values` and drive gains are the fit's.

    Raises:
        FitError: The fit's torques are currents, or no arm that can exist is near it.
    """
    if fit.unscaled:
        raise FitError(
            f"{fit.model.robot.name}: what the fit calls torque is current, and its masses are no masses. "
            "State drive gains in the robot file, or identify them with a known payload, then fit again"
        )
    base, values, covariance = _structure(fit)
    model = fit.model
    held = Held(base, model.nominal_values, _tolerance(fit, base, values), tuple(model.inertias))
    standard = fit.estimate.standard
    if fit.estimate.method != "consistent" or not _states(base, standard, values):
        standard = nearest(held, values, covariance)
    assert standard is not None
    return _stating(fit, standard, _deviation(held, covariance, [b.std for b in model.priors]))


def _structure(fit: Fit) -> tuple[BaseParameters, np.ndarray, np.ndarray]:
    """All base parameters, their values (b,) and covariance (b, b).

    Those that were dropped are zero, up to what they would have been: the data do not show more of them.
    """
    base, count = fit.structure or fit.base, len(fit.estimate.values)
    kept = [base.names.index(name) for name in _structural_names(fit)]
    values, covariance = np.zeros(len(base.names)), np.zeros((len(base.names),) * 2)
    for row, name in enumerate(base.names):
        covariance[row, row] = fit.dropped.get(name, 0.0) ** 2
    values[kept] = fit.estimate.values
    covariance[np.ix_(kept, kept)] = fit.estimate.covariance[:count, :count]
    return base, values, covariance


def _structural_names(fit: Fit) -> list[str]:
    """Names of the kept base parameters as the whole structure has them."""
    base = fit.structure or fit.base
    by_column = dict(zip(base.kept, base.names, strict=True))
    return [by_column[column] for column in fit.base.kept]


def _tolerance(fit: Fit, base: BaseParameters, values: np.ndarray) -> np.ndarray:
    """Deviation of each standard parameter before the data, shape (p,), finite and above zero."""
    std, weight = np.array([prior.std for prior in fit.model.priors]), np.abs(base.regrouping)
    usual = float(np.median(np.abs(values[values != 0.0]))) if np.any(values) else 1.0
    size = np.maximum(np.abs(values), TINY * usual)[:, None]
    scale = np.divide(size, weight, out=np.zeros_like(weight), where=weight > 0.0).max(axis=0)
    scale = np.where(scale > 0.0, scale, usual)  # in no base parameter: nothing of it is seen
    return np.where(np.isfinite(std), np.maximum(std, HELD * scale), WITHOUT_PRIOR * scale)


def _states(base: BaseParameters, standard: np.ndarray | None, values: np.ndarray) -> bool:
    """Whether standard parameters come to these base parameters."""
    if standard is None:
        return False
    return bool(np.allclose(base.regrouping @ standard, values, rtol=SAME, atol=SAME * np.abs(values).max()))


def _deviation(held: Held, covariance: np.ndarray, before: Sequence[float]) -> np.ndarray:
    """Standard deviation of each standard parameter after the data, shape (p,), given those before them."""
    size = np.sqrt(np.diag(covariance))
    size = np.where(size > 0.0, size, np.finfo(float).tiny)
    seen = whitening(covariance, size) @ held.base.regrouping * held.tolerance
    precision = seen.T @ seen + np.eye(seen.shape[1])
    left = cho_solve(cho_factor(precision), np.eye(len(precision)))
    share = np.sqrt(np.diag(left))
    # What neither the data nor anybody knows stays unknown.
    return np.where((share > UNSEEN) & np.isinf(before), np.inf, share * held.tolerance)


def _stating(fit: Fit, standard: np.ndarray, deviation: np.ndarray) -> Model:
    """The model with these as its priors: bodies in the robot, where it has them, all else stated."""
    model, stated, robot = fit.model, dict[str, Prior](), _with_gains(fit)
    for effect, own in zip(model.effects, model.columns, strict=True):
        if isinstance(effect, RigidBody):
            robot = with_bodies(robot, standard[own].reshape(robot.dof, 10))
            continue
        priors = zip(map(float, standard[own]), map(float, deviation[own]), strict=True)
        stated |= {name: Prior(*one) for name, one in zip(model.names[own], priors, strict=True)}
    return Model(robot, model.effects, stated)


def _with_gains(fit: Fit) -> Robot:
    robot, gain, std = fit.model.robot, fit.estimate.gain, fit.estimate.gain_std
    if fit.measures != "current":
        return robot
    tolerance = float(np.max(std / np.abs(gain))) if np.any(std > 0.0) else robot.drive_gain_tolerance
    return replace(robot, drive_gain=gain, drive_gain_tolerance=tolerance)


def with_bodies(robot: Robot, bodies: np.ndarray) -> Robot:
    """The robot with other links, ten parameters each in `INERTIAL` order, shape (n, 10)."""
    kinematics = robot.kinematics.copy()
    for link, values in enumerate(bodies):
        kinematics.inertias[link + 1] = body_inertia(values)
    return replace(robot, kinematics=kinematics)
