r"""Most probable parameters *and* drive gains given data and priors.

As maximum likelihood in current space, with the priors as further rows: standard parameters
:math:`\varphi_0 \pm T` through the base parameters they make, and gains :math:`g_0 (1 \pm \epsilon)`. No
known payload is needed: the priors set the scale. What fits only by leaving them shows in the residual.
"""

import numpy as np

from ...positive_definite import ROUNDING, factored, whitening
from ...preparation.noise import spectrum
from ..equations import Equations
from .bayesian import prior, standard_parameters
from .compressed import Compressed
from .covariance import noise_covariance
from .estimate import Estimate
from .maximum_likelihood import linearised

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
