r"""Bias of a fit that lacks friction under load.

Gears lose a share :math:`\mu` of the torque that they transmit:
:math:`\mu |\tau_{load}| \tanh(\dot q / v_r)`.
A fit without this effect is biased by the least-squares solution for that torque alone. The bias depends on
the motion of the fit's runs, and is several times the standard deviation of the fit: its residual shows only
what no base parameter absorbs. A payload that is identified with the fit needs it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..arm.motion import Motion
from ..effects.load_dependent_friction import LoadDependentFriction
from ..model import CHUNK, Model
from ..preparation.prepare import Prepared
from .equations import SMOOTH, Equations
from .estimators import Estimate

REVERSAL = 0.02
"""Velocity over which the friction reverses [rad/s], about that of Coulomb friction in industrial arms."""
ROUNDING = 1e-8
"""Smallest singular value over the largest, of columns of unit length, that is not zero by rounding."""


def gear_friction_bias(
    model: Model, equations: Equations, estimate: Estimate, runs: Sequence[Prepared]
) -> np.ndarray | None:
    """Bias of values, then gains, per friction over transmitted torque of each joint, shape (b + n, n).

    Returns:
        The bias; None if the model has friction under load.
    """
    n = len(estimate.gain)
    if any(isinstance(effect, LoadDependentFriction) for effect in model.effects):
        return None
    torque = equations.regressor @ estimate.values + equations.known
    residual = estimate.gain * equations.current - torque
    weight = equations.weight / np.maximum(np.std(residual, axis=0), np.finfo(float).tiny)
    friction = _friction(equations.base.applied_to(model, estimate.values), runs)
    by_gain = -np.eye(n)[:, estimate.gain_estimated] * (torque / estimate.gain)[:, :, None]
    jacobian = np.concatenate([equations.regressor, by_gain], axis=2)
    bias = np.zeros((len(estimate.values) + n, n))
    solved = np.append(np.full(len(estimate.values), True), estimate.gain_estimated)
    bias[solved] = _solve(jacobian * weight[:, :, None], friction * weight[:, :, None])
    return bias


def _friction(model: Model, runs: Sequence[Prepared]) -> np.ndarray:
    """Filtered friction torque per friction over transmitted torque, shape (r, n, n) [N m]."""
    friction, robot = LoadDependentFriction(reversal=REVERSAL), model.robot

    def pieces(motion: Motion) -> Iterator[np.ndarray]:
        for start in range(0, len(motion), CHUNK):
            piece = motion[start : start + CHUNK]
            yield friction.regressor(robot, replace(piece, load=model.gear_load(piece)))

    # Loads are smooth, and a sign that changes between samples moves the bias by a few millionths.
    filters = [run.decimation.thinned(SMOOTH * run.position_cutoff) for run in runs]
    columns = np.concatenate(
        [each.stream(pieces(run.motion[:: each.step])) for each, run in zip(filters, runs, strict=True)]
    )
    return np.einsum("ij,tjb->tib", robot.to_motors, columns)


def _solve(jacobian: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Least-squares solution (k, n) of (r, n, k) for (r, n, n)."""
    rows = jacobian.reshape(-1, jacobian.shape[2])
    size = np.maximum(np.linalg.norm(rows, axis=0), np.finfo(float).tiny)
    right = torque.reshape(-1, torque.shape[2])
    return np.asarray(np.linalg.lstsq(rows / size, right, rcond=ROUNDING)[0] / size[:, None])
