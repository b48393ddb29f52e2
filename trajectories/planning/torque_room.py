"""Room below the torque limits for what is not known of an arm: by its priors, or by an earlier fit."""

from collections.abc import Sequence

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.errors import FitError
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identified import standard_parameters
from exidyn.identification.model import Model

from ..search.drawn_arms import share_beyond
from ..search.experiment import loaded_runs
from ..search.goals import Goal
from ..search.torque_spread import TorqueSpread, spread_of
from ..trajectory import Trajectory
from .goals import typical_states

FINE = 0.01
"""Spacing at which drawn arms are looked at [s]: a joint at 3 rad/s moves 0.03 rad, and its torque by a
thousandth of what a quarter turn changes it by."""


def torque_spread(
    model: Model, limits: Limits, payloads: Sequence[str], sure: float, fit: Fit | None = None
) -> TorqueSpread | None:
    """What is not known of the torque; None where nothing is unsure, or no torque is limited.

    Args:
        model: Whose nominal torque is kept to the limits.
        limits: Those that the motion keeps to.
        payloads: Body carried in each run.
        sure: Share of arms within what is known that keep to the limits; 0 for the nominal one alone.
        fit: Of earlier runs; what it found stands for the priors, and torque that it does not explain counts.
    """
    if not sure or not np.any(np.isfinite(limits.torque)):
        return None
    runs = loaded_runs(model, typical_states(limits).motion(), payloads)
    columns = np.concatenate([model.regressor(run) for run in runs])
    covariance = _of_priors(model)
    residual = np.zeros(model.robot.dof)
    if fit is not None:
        covariance, residual = _of_fit(fit, model), np.abs(fit.estimate.noise)
    return spread_of(covariance, sure, residual, columns)


def _of_priors(model: Model) -> np.ndarray:
    """Covariance of the model's parameters by its priors, shape (p, p)."""
    return np.diag(np.square([prior.std for prior in model.priors]))


def _of_fit(fit: Fit, model: Model) -> np.ndarray:
    """The same by a fit, and by the priors for what is not in it: bodies that no run carried."""
    covariance = _of_priors(model)
    try:
        found = standard_parameters(fit).covariance
    except FitError:  # torques that are currents: what the fit itself says of their combinations
        kept = fit.base.kept
        found = np.zeros((len(fit.model.names),) * 2)
        found[np.ix_(kept, kept)] = fit.estimate.covariance[: len(kept), : len(kept)]
    places = [model.names.index(name) for name in fit.model.names if name in model.names]
    own = [k for k, name in enumerate(fit.model.names) if name in model.names]
    covariance[np.ix_(places, places)] = found[np.ix_(own, own)]
    return covariance


def arms_beyond(goal: Goal, run: Trajectory, limit: np.ndarray) -> float:
    """Share of arms, drawn within what is known, that pass a torque limit (n,) in some run of a motion."""
    return share_beyond(goal, run.every(FINE), limit)
