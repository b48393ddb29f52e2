r"""Most probable unknowns given the runs and what is known of the arm, with their covariance.

With :math:`\hat g` the assumed gain of a joint and e the logarithm of its ratio to the true gain, the
measured torque is :math:`\hat g\, i = \exp(e)\, (W \beta + P \varphi + W_c \delta)`: arm, payload, changes of
friction. The unknowns are written as mean + R z with the prior covariance :math:`R R^T`, so that z has unit
variance.

Without a fit, errors of the arm are R z over :math:`\exp(w^T e)`, with shares w of the joints that show them:
a tolerance says nothing about gains. If errors did not scale, a gain that makes all parameters smaller would
make their errors more probable, and masses would be too low by the square of the tolerance.

Noise and model errors are colored. Weights for white noise would overrate the data several times compared
with the prior; so each joint has the weight of its noise near zero frequency (`_slowness`). The covariance is
the sandwich of `estimators.covariance`, from autocovariances of the residual and from the scatter between
blocks.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ..fit.equations import Equations
from ..fit.estimators.colored_noise import noise_covariance, spectrum
from ..fit.estimators.covariance import sandwich
from ..positive_definite import ROUNDING
from .known import Known
from .rows import Rows

ITERATIONS = 20
SETTLED = 1e-3
"""Largest step in prior standard deviations at which the iteration ends."""
UNSEEN = 1e-8
"""Information on an unknown, over that of the prior, below which the data count as silent: rounding."""
FEWEST = 5.0
"""Least degrees of freedom of a joint's noise level."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """Unknowns after the runs."""

    rows: Rows  # equations of the runs
    values: np.ndarray  # arm, payload, changes, relative gain errors, shape (k,)
    covariance: np.ndarray  # covariance of the values, shape (k, k)
    certain: np.ndarray  # covariance of the payload if arm and gains were known exactly, shape (10, 10)
    residual: np.ndarray  # measured minus predicted torque, shape (r, n) [N m]
    jacobian: np.ndarray  # derivative of the predicted torque by the values, shape (r, n, k)
    noise: np.ndarray  # standard deviation of each joint's noise, shape (n,) [N m]
    slow: np.ndarray  # noise amplitude near zero frequency over that of white noise, shape (n,) [-]

    @property
    def payload(self) -> np.ndarray:
        """Ten parameters of the payload, shape (10,)."""
        return self.values[self.rows.payload]


def posterior(rows: Rows, known: Known) -> Posterior:
    """Gauss-Newton iteration from the prior mean, which estimates the noise of each joint again."""
    equations, columns = rows.equations, rows.columns
    measured = equations.gain * equations.current - equations.known
    n = measured.shape[1]
    z, noise = np.zeros(len(known.mean)), np.sqrt(np.mean(measured**2, axis=0))  # until the first fit
    slow, share = np.ones(n), _share(columns, equations.weight / noise, rows.arm * known.scaled)
    for iteration in range(ITERATIONS):
        values, slope = _unscaled(z, known, share)
        jacobian = _jacobian(columns, values, n)
        residual = measured - _predicted(columns, values, n)
        step = _step(jacobian @ slope, residual, equations.weight / (noise * slow), z)
        z = z + step
        values, slope = _unscaled(z, known, share)
        residual = measured - _predicted(columns, values, n)
        noise = _level(residual, equations, columns.shape[2] / n)
        slow = _slowness(residual, equations)
        if iteration > 1 and np.max(np.abs(step)) < SETTLED:
            break
    spread = _spread(jacobian @ slope, residual, equations, slow)
    covariance = slope @ spread @ slope.T
    certain = _certain(jacobian, residual, rows, slow, known)
    return Posterior(rows, values, covariance, certain, residual, jacobian, noise, slow)


def _predicted(columns: np.ndarray, values: np.ndarray, n: int) -> np.ndarray:
    """Predicted torque, shape (r, n) [N m]."""
    return np.asarray((columns @ values[:-n]) * np.exp(values[-n:]))


def _jacobian(columns: np.ndarray, values: np.ndarray, n: int) -> np.ndarray:
    """Derivative of the predicted torque by the values, shape (r, n, k)."""
    by_gain = np.eye(n) * _predicted(columns, values, n)[:, :, None]
    return np.concatenate([columns * np.exp(values[-n:])[:, None], by_gain], axis=2)


def _step(whitened: np.ndarray, residual: np.ndarray, weight: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Step of z (k,) that minimizes the weighted squares of the residual plus those of z."""
    rows = (whitened * weight[:, :, None]).reshape(-1, len(z))
    right = (residual * weight).ravel()
    gram = rows.T @ rows
    # Unit prior information: directions in which the data have less than rounding stay at the prior.
    size = np.sqrt(np.diag(gram) + 1.0)
    scaled = (gram + np.eye(len(z))) / np.outer(size, size)
    scaled[np.diag_indices_from(scaled)] += ROUNDING
    return np.asarray(np.linalg.solve(scaled, (rows.T @ right - z) / size) / size)


def _share(columns: np.ndarray, weight: np.ndarray, arm: int) -> np.ndarray:
    """Share of each joint in the information on each unknown, shape (k, n); zero except for the arm's."""
    size = np.einsum("rnk,rn->kn", columns[:, :, :arm] ** 2, weight**2)
    share = size / np.maximum(np.sum(size, axis=1, keepdims=True), np.finfo(float).tiny)
    return np.pad(share, ((0, columns.shape[2] + weight.shape[1] - arm), (0, 0)))


def _unscaled(z: np.ndarray, known: Known, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values (k,) at z (k,), and their derivative (k, k)."""
    n = share.shape[1]
    deviation = known.root @ z
    scale = np.exp(-share @ (known.mean + deviation)[-n:])
    slope = scale[:, None] * known.root - (scale * deviation)[:, None] * (share @ known.root[-n:])
    return known.mean + scale * deviation, slope


def _level(residual: np.ndarray, equations: Equations, per_joint: float) -> np.ndarray:
    """Standard deviation of each joint's residual, shape (n,) [N m]; the floor is the recorded noise."""
    freedom = np.maximum(equations.weight.sum(axis=0) - per_joint, FEWEST)
    level = np.sqrt(np.sum(equations.weight * residual**2, axis=0) / freedom)
    return np.maximum(level, np.abs(equations.gain) * equations.noise + 1e-9 * np.max(level))


def _slowness(residual: np.ndarray, equations: Equations) -> np.ndarray:
    """Noise amplitude near zero frequency over that of white noise with the same variance, at least 1."""
    density = np.diagonal(spectrum(noise_covariance(residual, equations), 64), axis1=1, axis2=2).real
    usual = np.mean(density, axis=0)
    ratio = np.divide(density[0], usual, out=np.ones_like(usual), where=usual > 0.0)
    return np.sqrt(np.maximum(ratio, 1.0))


def _certain(
    jacobian: np.ndarray, residual: np.ndarray, rows: Rows, slow: np.ndarray, known: Known
) -> np.ndarray:
    """Covariance of the payload (10, 10) from noise alone: arm, gains and friction are exact."""
    loaded = np.flatnonzero(rows.loaded)
    lengths = [run.stop - run.start for run in rows.equations.runs if rows.loaded[run.start]]
    stops = np.cumsum([0, *lengths]).tolist()
    root = known.root[rows.payload, rows.payload]  # the payload's prior does not depend on the others
    part = jacobian[loaded][:, :, rows.payload]
    equations = replace(
        rows.equations,
        regressor=part,
        current=rows.equations.current[loaded],
        weight=rows.equations.weight[loaded],
        first=rows.equations.first[loaded],
        runs=tuple(slice(first, last) for first, last in pairwise(stops)),
    )
    return np.asarray(root @ _spread(part @ root, residual[loaded], equations, slow) @ root.T)


def _spread(jacobian: np.ndarray, residual: np.ndarray, equations: Equations, slow: np.ndarray) -> np.ndarray:
    """Covariance (k, k) of unknowns with unit prior variance; see the module's docstring."""
    size = np.maximum(np.sqrt(np.mean(residual**2, axis=0)), np.finfo(float).tiny)
    information = np.einsum("rnk,rnk,n->k", jacobian, jacobian, size**-2.0, optimize=True)
    seen = np.flatnonzero(information > UNSEEN)
    part = jacobian[:, :, seen]
    spread = sandwich(
        part, residual, equations, instruments=part / slow[:, None] ** 2, before=np.ones(len(seen))
    )
    covariance = np.eye(jacobian.shape[2])
    covariance[np.ix_(seen, seen)] = spread.covariance
    return covariance
