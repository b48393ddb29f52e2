r"""Maximum likelihood in current space, for drive gains and dynamics together.

Noise sits in the currents, so they are what is predicted:
:math:`\sum_j \| i_j - \gamma_j (W_j \chi + P_j) \|^2 / \sigma_j^2` with :math:`\gamma_j = 1/g_j`. Unlike
least squares in torque, where noisy currents are regressors and pull the gains down, it is unbiased.
"""

import numpy as np

from ..equations import Equations
from .compressed import Compressed, solve
from .covariance import sandwich_with_gains
from .estimate import Estimate
from .total_least_squares import mixed, require_payload


def maximum_likelihood(equations: Equations) -> Estimate:
    """Gauss-Newton from the mixed total least squares solution, noise of each joint re-estimated."""
    require_payload(equations)
    compressed = Compressed.of(equations)
    start = mixed(equations)
    values, inverse = start.values, 1.0 / start.gain
    for _ in range(50):
        noise = compressed.residual_std(values, 1.0 / inverse) * np.abs(inverse)
        labels = [*equations.names, *(f"drive gain {j + 1}" for j in range(len(noise)))]
        step = solve(*linearised(compressed, values, inverse, noise), labels)
        values, inverse = values + step[: len(values)], inverse + step[len(values) :]
        if np.max(np.abs(step[len(values) :] / inverse)) < 1e-10:
            break
    gain = 1.0 / inverse
    covariance = sandwich_with_gains(equations, values, gain)
    return Estimate("maximum likelihood", values, gain, covariance, compressed.residual_std(values, gain))


def linearised(
    compressed: Compressed, values: np.ndarray, inverse: np.ndarray, noise: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Rows and right-hand side of a Gauss-Newton step of values (b,) and inverse gains (n,) [A/(N m)].

    Rows are divided by the noise of each joint's current, shape (n,) [A].
    """
    rows, right = [], []
    n = len(inverse)
    for joint in range(n):
        torque = compressed.regressor(joint) @ values + compressed.known(joint)
        by_gain = np.zeros((len(torque), n))
        by_gain[:, joint] = torque
        rows.append(np.column_stack([inverse[joint] * compressed.regressor(joint), by_gain]) / noise[joint])
        right.append((compressed.current(joint) - inverse[joint] * torque) / noise[joint])
    return np.concatenate(rows), np.concatenate(right)
