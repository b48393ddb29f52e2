r"""Instrumental variables: robust to noise that the position loop feeds back into the motion.

In a closed loop the measured motion follows the torque noise, so regressor and noise correlate and least
squares is biased. The commanded motion does not know the noise; its regressor Z serves as instrument:
:math:`\hat\chi = (Z^T W)^{-1} Z^T \tau` (Janot, Vandanjon, Gautier 2014).
"""

import numpy as np

from ...errors import FitError
from ..equations import Equations
from .covariance import sandwich
from .estimate import Estimate
from .least_squares import residual, weighted


def instrumental(equations: Equations) -> Estimate:
    """Instrumental variables with the commanded motion, joints weighted by their noise.

    Raises:
        FitError: The runs hold no commanded positions.
    """
    if equations.commanded is None:
        raise FitError(
            "instrumental variables need the commanded positions in every run; "
            "record them, or use the 'weighted' estimator"
        )
    start = weighted(equations)
    noise, commanded = start.noise, equations.commanded()
    instrument = commanded * equations.weight[:, :, None]
    values = start.values
    for _ in range(5):
        scaled = instrument / noise[None, :, None] ** 2
        normal = np.einsum("rnb,rnc->bc", scaled, equations.regressor)
        torque = equations.gain * equations.current - equations.known
        size = np.sqrt(np.abs(np.diag(normal)))
        right = np.einsum("rnb,rn->b", scaled, torque)
        values = np.linalg.solve(normal / np.outer(size, size), right / size) / size
        left = residual(equations, values, equations.gain)
        noise = np.sqrt(np.sum(equations.weight * left**2, axis=0) / equations.weight.sum(axis=0))
    covariance = sandwich(equations.regressor, left, equations, commanded)
    full = np.pad(covariance, (0, len(equations.gain)))
    return Estimate("instrumental", values, equations.gain, full, noise)
