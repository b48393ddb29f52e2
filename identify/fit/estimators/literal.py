r"""The paper's method: total least squares without weights.

The homogeneous system of the paper's (12), [V, -W, -P] [gain, values, 1] = rho, is solved by the right
singular vector of the smallest singular value. This is optimal only if every entry of the matrix carries the
same noise. It does not: currents of a few amperes stand beside columns of hundreds of rad/s^2, and joints
differ in noise. The paper's covariance (20) assumes white noise; with a colored residual, its intervals are
too narrow.
"""

import numpy as np
from scipy import linalg

from ..equations import Equations
from .compressed import Compressed, Estimate
from .drive_gains import homogeneous, require_payload


def literal(equations: Equations) -> Estimate:
    """Total least squares as in the paper's (12) to (21), without weights."""
    require_payload(equations)
    compressed, n = Compressed.of(equations), len(equations.gain)
    system = homogeneous(compressed, np.ones(n))
    _, singular, right = linalg.svd(system, full_matrices=False)
    last = right[-1]
    unknowns = last[:-1] / last[-1]
    deviation = singular[-1] / np.sqrt(compressed.counts.sum() - system.shape[1])
    compatible = system - np.outer(system @ last, last)
    gram = compatible[:, :-1].T @ compatible[:, :-1]
    covariance = deviation**2 * (1 + unknowns @ unknowns) * np.linalg.pinv(gram, hermitian=True)
    order = np.concatenate([np.arange(n, len(covariance)), np.arange(n)])
    gain, values = unknowns[:n], unknowns[n:]
    noise = compressed.residual_std(values, gain)
    return Estimate("literal", values, gain, covariance[np.ix_(order, order)], noise)
