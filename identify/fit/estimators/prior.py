r"""Prior of the base parameters from that of the standard parameters.

The prior of the standard parameters is :math:`\varphi_0 \pm T`. The data depend only on the base parameters
:math:`\chi = K \varphi`, so their prior is :math:`\chi \sim N(K \varphi_0, K T^2 K^T)`. It resolves what a
motion cannot, such as a spring balancer against gravity over a short range of the joint.
"""

import numpy as np

from ..equations import Equations


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
