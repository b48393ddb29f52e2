"""Room below the torque limits for the uncertainty of an arm's parameters, from priors or an earlier fit."""

from collections.abc import Sequence

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.errors import FitError
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identified import standard_parameters
from exidyn.identification.model import Model

from ..search.experiment import loaded_runs
from ..search.torque_spread import TorqueSpread, spread_of
from .goals import typical_states


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
