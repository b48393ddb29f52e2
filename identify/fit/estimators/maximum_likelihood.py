r"""Maximum likelihood in current space, for drive gains and dynamics together.

Noise sits in the currents, so they are what is predicted:
:math:`\sum_j \| i_j - \gamma_j (W_j \chi + P_j) \|^2 / \sigma_j^2` with :math:`\gamma_j = 1/g_j`. Unlike
least squares in torque, where noisy currents are regressors and pull the gains down, it is unbiased.
"""

import numpy as np

from ..equations import Equations
from .compressed import Compressed, Estimate, solve
from .covariance import sandwich_with_gains
from .least_squares import weighted_values
from .total_least_squares import mixed, require_payload

WIDE = 10.0
"""Deviation over value of a gain before the data: so wide that it counts where they show nothing."""

FAR = 10.0
"""Factor between the errors of stated gains from which one has not been seen: motors are not so wrong."""

LOST = 1e4
"""Factor from stated gains at which nothing was seen of any: a mass in grams is a factor of a thousand."""


def maximum_likelihood(equations: Equations) -> Estimate:
    """Gauss-Newton from the mixed total least squares solution, noise of each joint re-estimated."""
    require_payload(equations)
    compressed = Compressed.of(equations)
    values, gain = _start(equations, compressed)
    centre = gain
    for _ in range(50):
        noise = compressed.residual_std(values, gain) / np.abs(gain)
        labels = [*equations.names, *(f"drive gain {j + 1}" for j in range(len(noise)))]
        rows, right = linearised(compressed, values, 1.0 / gain, noise)
        loose = np.diag(-(gain**2) / (WIDE * np.abs(centre)))
        rows = np.concatenate([rows, np.pad(loose, ((0, 0), (len(values), 0)))])
        step = solve(rows, np.concatenate([right, (centre - gain) / (WIDE * np.abs(centre))]), labels)
        # Steps are of gains, not of their inverse: values that depend on an open gain stay its multiples.
        change = -(gain**2) * step[len(values) :]
        values, gain = values + step[: len(values)], gain + change
        if np.max(np.abs(change / gain)) < 1e-10:
            break
    covariance = sandwich_with_gains(equations, values, gain, WIDE * centre)
    return Estimate("maximum likelihood", values, gain, covariance, compressed.residual_std(values, gain))


def _start(equations: Equations, compressed: Compressed) -> tuple[np.ndarray, np.ndarray]:
    """Values (b,) and gains (n,) to begin with: mixed total least squares, but for gains that it cannot see.

    Of a joint in which the payload makes no torque its smallest singular vector may be that joint's alone,
    with any gain, or no payload in it. Such a gain begins as it is stated, at the scale of the others.
    """
    try:
        with np.errstate(divide="ignore", invalid="ignore"):
            found = mixed(equations)
        values, gain = found.values, found.gain
    except (np.linalg.LinAlgError, ValueError):
        return weighted_values(equations, equations.gain, compressed), equations.gain
    share = np.abs(gain / equations.gain)
    usual = float(share[np.argmin(np.abs(np.log(share)))])
    if not 1.0 / LOST < usual < LOST:
        return weighted_values(equations, equations.gain, compressed), equations.gain
    seen = (share > usual / FAR) & (share < usual * FAR)
    if np.all(seen) or np.all(equations.gain == 1.0):
        return values, gain
    gain = np.where(seen, gain, usual * equations.gain)
    return weighted_values(equations, gain, compressed), gain


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
