r"""Bias of a fit that lacks friction under load.

Gears lose a share :math:`\mu` of the torque that they transmit:
:math:`\mu |\tau_{load}| \tanh(\dot q / v_r)`.
A fit without this effect is biased by the least-squares solution for that torque alone. The bias depends on
the motion of the fit's runs, and is several times the standard deviation of the fit: its residual shows only
what no base parameter absorbs. A payload that is identified with the fit needs it.
"""

import numpy as np

from ..effects.load_dependent_friction import LoadDependentFriction
from ..model import Model
from .equations import Equations
from .estimators import Estimate

REVERSAL = 0.02
"""Velocity over which the friction reverses [rad/s], about that of Coulomb friction in industrial arms."""
ROUNDING = 1e-8
"""Smallest singular value over the largest, of columns of unit length, that is not zero by rounding."""


def gear_friction_bias(
    model: Model, equations: Equations, estimate: Estimate, velocity: np.ndarray
) -> np.ndarray | None:
    """Bias of the values per friction over transmitted torque of each joint, shape (b, n).

    Args:
        model: Model of the fit.
        equations: Equations of its runs.
        estimate: Its values and gains.
        velocity: Joint velocity at the rows, shape (r, n) [rad/s].

    Returns:
        The bias; None if the model has friction under load, motors drive several joints, or torque is from
        currents. With estimated gains, the solution is not linear enough: intervals became too narrow.
    """
    n = len(estimate.gain)
    has_friction = any(isinstance(effect, LoadDependentFriction) for effect in model.effects)
    if has_friction or not equations.gain_known or not np.array_equal(model.robot.to_motors, np.eye(n)):
        return None
    residual = equations.current - equations.regressor @ estimate.values - equations.known
    weight = equations.weight / np.maximum(np.std(residual, axis=0), np.finfo(float).tiny)
    friction = np.eye(n) * _friction(model, equations, estimate, velocity)[:, :, None]
    return _solve(equations.regressor * weight[:, :, None], friction * weight[:, :, None])


def _friction(model: Model, equations: Equations, estimate: Estimate, velocity: np.ndarray) -> np.ndarray:
    """Friction torque per friction over transmitted torque, shape (r, n) [N m]."""
    rubbing = {
        column
        for effect, columns in zip(model.effects, model.columns, strict=True)
        if effect.greased or effect.guessed
        for column in range(columns.start, columns.stop)
    }
    links = [k for k, column in enumerate(equations.base.kept) if int(column) not in rubbing]
    load = equations.regressor[:, :, links] @ estimate.values[links] + equations.known
    return np.asarray(np.abs(load) * np.tanh(velocity / REVERSAL))


def _solve(jacobian: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Least-squares solution (k, n) of (r, n, k) for (r, n, n)."""
    rows = jacobian.reshape(-1, jacobian.shape[2])
    size = np.maximum(np.linalg.norm(rows, axis=0), np.finfo(float).tiny)
    right = torque.reshape(-1, torque.shape[2])
    return np.asarray(np.linalg.lstsq(rows / size, right, rcond=ROUNDING)[0] / size[:, None])
