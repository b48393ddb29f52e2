r"""Estimates with a prior: `bayesian`, weighted least squares, and `posterior`, which finds drive gains too.

Standard parameters are held to be :math:`\varphi_0 \pm T`. The data see base parameters
:math:`\chi = K \varphi` alone, so the prior is :math:`\chi \sim N(K \varphi_0, K T^2 K^T)`. It settles
what a motion cannot: a spring balancer against gravity over a short range of its joint, for instance.

`posterior` is maximum likelihood in current space with the priors as further rows: those of the standard
parameters through the base parameters they make, and gains :math:`g_0 (1 \pm \epsilon)`. No known payload is
needed: the priors set the scale. What fits only by leaving them shows in the residual.
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

    The data enter with the covariance of coloured noise: weights as if it were white would trust the
    data several times too much against the priors. Gains stay nominal, and with them the scale that values
    have: what is probable is so given the gains, and what they may be off by comes on top.
    """
    data, (mean, deviation) = weighted(equations), prior(equations)
    given, by_gain = given_nominal(data), slope(data)
    values, covariance = joined(data.values, given, mean, deviation)
    by_gain, _ = joined(by_gain, given, np.zeros_like(by_gain), deviation)  # the priors hold values back
    full = with_nominal_gains(covariance, by_gain, gain_deviation(equations))
    noise = Compressed.of(equations).residual_std(values, equations.gain)
    standard = standard_parameters(equations, values)
    return Estimate("bayesian", values, equations.gain, full, noise, standard, nominal_gains=True)


def joined(
    values: np.ndarray, covariance: np.ndarray, mean: np.ndarray, deviation: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Mean (b,) or (b, m) and covariance (b, b) when two independent ones are joined, scaled for rounding."""
    total = covariance + deviation
    share = solve(factored(total), covariance).T  # Kalman's gain
    both = share @ deviation
    return values + share @ (mean - values), 0.5 * (both + both.T)


def prior(equations: Equations) -> tuple[np.ndarray, np.ndarray]:
    """Mean (b,) and covariance (b, b) of the base parameters before the data."""
    regrouping, deviation = equations.base.regrouping, finite_tolerance(equations)
    spread = regrouping * deviation
    return regrouping @ equations.nominal, spread @ spread.T


LOOSE = 10.0
"""Deviation of what has no prior, over what would make the whole measured torque alone: wide
enough to have no effect, and no wider, since rounding grows with it."""


def finite_tolerance(equations: Equations) -> np.ndarray:
    """Standard deviation of each standard parameter, shape (p,), finite also where nothing is held."""
    torque = np.linalg.norm((equations.gain * equations.current)[equations.weight > 0])
    rows = (equations.regressor * equations.weight[:, :, None]).reshape(-1, len(equations.names))
    # A column that was regrouped is this combination of the kept ones; unseen columns have no length.
    regrouping = equations.base.regrouping
    size = np.sqrt(np.einsum("bp,bc,cp->p", regrouping, rows.T @ rows, regrouping, optimize=True))
    seen = size > 0
    loose = LOOSE * torque / np.where(seen, size, np.median(size[seen]))
    # A nominal zero with zero tolerance would make the prior singular; it is held to a billionth.
    return np.where(np.isfinite(equations.tolerance), np.maximum(equations.tolerance, 1e-9 * loose), loose)


def standard_parameters(equations: Equations, values: np.ndarray) -> np.ndarray:
    """Most probable standard parameters (p,) for given base parameters (b,)."""
    spread = equations.base.regrouping * finite_tolerance(equations)
    mean = equations.base.regrouping @ equations.nominal
    change = np.linalg.lstsq(spread, values - mean, rcond=None)[0]
    return equations.nominal + finite_tolerance(equations) * change


CERTAIN = 1e-9
"""Relative deviation of a gain that is known by definition, where torque itself was recorded."""


def posterior(equations: Equations) -> Estimate:
    """Gauss-Newton from the priors, noise of each joint re-estimated."""
    compressed, count = Compressed.of(equations), len(equations.names)
    mean, deviation = prior(equations)
    held = whitening(factored(deviation))
    nominal = 1.0 / equations.gain
    certain = 1.0 / np.abs(nominal * np.maximum(equations.gain_tolerance, CERTAIN))
    values, inverse = mean, nominal
    colour = np.ones(len(nominal))
    for _ in range(50):
        noise = compressed.residual_std(values, 1.0 / inverse) * np.abs(inverse) * colour
        rows, right = linearised(compressed, values, inverse, noise)
        rows = np.block([[rows], [held, np.zeros((count, len(inverse)))],
                         [np.zeros((len(inverse), count)), np.diag(certain)]])  # fmt: skip
        right = np.concatenate([right, held @ (mean - values), certain * (nominal - inverse)])
        step, covariance = _solve(rows, right)
        values, inverse = values + step[:count], inverse + step[count:]
        colour = slowness(equations, values, inverse)
        if np.max(np.abs(step) / np.sqrt(np.diag(covariance))) < 1e-3:
            break
    # Gains that are one by definition come back as one to a billionth, and as not estimated.
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


def slowness(equations: Equations, values: np.ndarray, inverse: np.ndarray) -> np.ndarray:
    """How much more slow noise there is than white noise of the same variance, at least 1, shape (n,).

    Rows of the regressor change slowly, so what averages out is the noise's density near zero
    frequency. White weights would let the data outvote the priors many times over.
    """
    residual = equations.current - inverse * (equations.regressor @ values + equations.known)
    density = spectrum(noise_covariance(residual, equations), 64)
    density = np.diagonal(density, axis1=1, axis2=2).real
    usual = np.mean(density, axis=0)
    slow = np.divide(density[0], usual, out=np.ones_like(usual), where=usual > 0)
    return np.sqrt(np.maximum(slow, 1.0))


def _solve(rows: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least squares and its covariance, columns scaled to one; what nothing shows has a wide deviation."""
    size = np.linalg.norm(rows, axis=0)
    left, spread, axes = np.linalg.svd(rows / size, full_matrices=False)
    inverse = axes.T / np.maximum(spread, ROUNDING * spread[0])
    return (inverse @ (left.T @ right)) / size, inverse @ inverse.T / np.outer(size, size)
