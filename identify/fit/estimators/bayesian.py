r"""Estimators with priors: `bayesian` extends weighted least squares; `posterior` also estimates drive gains.

The prior of the standard parameters is :math:`\varphi_0 \pm T`. The data depend only on the base parameters
:math:`\chi = K \varphi`, so their prior is :math:`\chi \sim N(K \varphi_0, K T^2 K^T)`. It resolves what a
motion cannot, such as a spring balancer against gravity over a short range of the joint.

`posterior` is maximum likelihood in current space with additional rows for the priors: those of the base
parameters, and gains :math:`g_0 (1 \pm \epsilon)`. It needs no known payload, because the priors set the
scale. A contradiction between data and priors shows in the residual.
"""

import numpy as np

from ...positive_definite import ROUNDING, factored, solve, whitening
from ...preparation.noise import spectrum
from ..equations import Equations
from .compressed import Compressed, Estimate
from .covariance import noise_covariance
from .drive_gains import linearised
from .least_squares import weighted
from .nominal_gains import gain_deviation, given_nominal, slope, with_nominal_gains


def bayesian(equations: Equations) -> Estimate:
    """Most probable base parameters given data and priors.

    The data enter with the covariance of colored noise: weights for white noise would overrate the data
    several times compared with the priors. Gains stay nominal and set the scale of all values. The values
    are the most probable ones at these gains; the uncertainty of the gains is added to the covariance.
    """
    data, (mean, prior_covariance) = weighted(equations), prior(equations)
    covariance, by_gain = given_nominal(data), slope(data)
    values, combined = joined(data.values, covariance, mean, prior_covariance)
    # The priors reduce the effect of the gains on the values.
    by_gain, _ = joined(by_gain, covariance, np.zeros_like(by_gain), prior_covariance)
    full = with_nominal_gains(combined, by_gain, gain_deviation(equations))
    noise = Compressed.of(equations).residual_std(values, equations.gain)
    standard = standard_parameters(equations, values)
    return Estimate("bayesian", values, equations.gain, full, noise, standard, nominal_gains=True)


def joined(
    values: np.ndarray, covariance: np.ndarray, mean: np.ndarray, prior_covariance: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Combine two independent Gaussians: mean, shape (b,) or (b, m), and covariance, shape (b, b)."""
    total = covariance + prior_covariance
    share = solve(factored(total), covariance).T  # Kalman's gain
    combined = share @ prior_covariance
    return values + share @ (mean - values), 0.5 * (combined + combined.T)


def prior(equations: Equations) -> tuple[np.ndarray, np.ndarray]:
    """Mean (b,) and covariance (b, b) of the prior of the base parameters."""
    regrouping, deviation = equations.base.regrouping, finite_tolerance(equations)
    spread = regrouping * deviation
    return regrouping @ equations.nominal, spread @ spread.T


LOOSE = 10.0
"""Standard deviation for a parameter without a prior, over the value that alone would explain the whole
measured torque: wide enough to have no effect, and no wider, since rounding errors grow with it."""


def finite_tolerance(equations: Equations) -> np.ndarray:
    """Prior standard deviation of each standard parameter, shape (p,); finite even without a prior."""
    torque = np.linalg.norm((equations.gain * equations.current)[equations.weight > 0])
    rows = (equations.regressor * equations.weight[:, :, None]).reshape(-1, len(equations.names))
    # A regrouped column is a combination of base columns; the norm of an unobservable column is zero.
    regrouping = equations.base.regrouping
    size = np.sqrt(np.einsum("bp,bc,cp->p", regrouping, rows.T @ rows, regrouping, optimize=True))
    seen = size > 0
    loose = LOOSE * torque / np.where(seen, size, np.median(size[seen]))
    # A nominal zero with zero tolerance would make the prior singular; it gets a tiny tolerance instead.
    return np.where(np.isfinite(equations.tolerance), np.maximum(equations.tolerance, 1e-9 * loose), loose)


def standard_parameters(equations: Equations, values: np.ndarray) -> np.ndarray:
    """Most probable standard parameters (p,) for base parameters (b,)."""
    spread = equations.base.regrouping * finite_tolerance(equations)
    mean = equations.base.regrouping @ equations.nominal
    change = np.linalg.lstsq(spread, values - mean, rcond=None)[0]
    return equations.nominal + finite_tolerance(equations) * change


CERTAIN = 1e-9
"""Relative standard deviation of a gain that is one by definition because torque was recorded."""


def posterior(equations: Equations) -> Estimate:
    """Gauss-Newton iteration that starts at the priors and re-estimates the noise of each joint."""
    compressed, count = Compressed.of(equations), len(equations.names)
    mean, prior_covariance = prior(equations)
    held = whitening(factored(prior_covariance))
    nominal = 1.0 / equations.gain
    certain = 1.0 / np.abs(nominal * np.maximum(equations.gain_tolerance, CERTAIN))
    values, inverse = mean, nominal
    color = np.ones(len(nominal))
    for _ in range(50):
        noise = compressed.residual_std(values, 1.0 / inverse) * np.abs(inverse) * color
        rows, right = linearised(compressed, values, inverse, noise)
        rows = np.block([[rows], [held, np.zeros((count, len(inverse)))],
                         [np.zeros((len(inverse), count)), np.diag(certain)]])  # fmt: skip
        right = np.concatenate([right, held @ (mean - values), certain * (nominal - inverse)])
        step, covariance = _solve(rows, right)
        values, inverse = values + step[:count], inverse + step[count:]
        color = _slowness(equations, values, inverse)
        if np.max(np.abs(step) / np.sqrt(np.diag(covariance))) < 1e-3:
            break
    # Gains that are one by definition are returned exactly, and marked as not estimated.
    gain = equations.gain if equations.gain_known else 1.0 / inverse
    slope = np.concatenate([np.ones(count), np.zeros_like(gain) if equations.gain_known else -(gain**2)])
    return Estimate(
        "posterior",
        values,
        gain,
        covariance * np.outer(slope, slope),
        compressed.residual_std(values, gain),
        standard_parameters(equations, values),
    )


def _slowness(equations: Equations, values: np.ndarray, inverse: np.ndarray) -> np.ndarray:
    """Noise amplitude near zero frequency over that of white noise with the same variance, shape (n,).

    Rows of the regressor change slowly, so the noise density near zero frequency determines the uncertainty.
    Weights for white noise would overrate the data compared with the priors. The value is at least 1.
    """
    residual = equations.current - inverse * (equations.regressor @ values + equations.known)
    density = spectrum(noise_covariance(residual, equations), 64)
    density = np.diagonal(density, axis1=1, axis2=2).real
    usual = np.mean(density, axis=0)
    slow = np.divide(density[0], usual, out=np.ones_like(usual), where=usual > 0)
    return np.sqrt(np.maximum(slow, 1.0))


def _solve(rows: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least-squares solution and covariance; directions that nothing determines get a large std."""
    size = np.linalg.norm(rows, axis=0)
    u, singular, axes = np.linalg.svd(rows / size, full_matrices=False)
    inverse = axes.T / np.maximum(singular, ROUNDING * singular[0])
    return (inverse @ (u.T @ right)) / size, inverse @ inverse.T / np.outer(size, size)
