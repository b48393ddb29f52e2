r"""Maximum likelihood: drive gains and dynamics from runs with and without a known payload.

The noise is in the currents, so the model predicts currents and minimizes
:math:`\sum_j \| i_j - \gamma_j (W_j \chi + P_j) \|^2 / \sigma_j^2` with :math:`\gamma_j = 1/g_j`. It is
unbiased, unlike least squares in torque, where noisy currents are regressors and bias the gains low.

The iteration starts at a total least squares solution of [V, -W, -P] [gain, values, 1] = 0, with rows divided
by their torque noise and an exact regressor (Van Huffel and Vandewalle, the mixed LS-TLS problem).
"""

from dataclasses import replace

import numpy as np
from scipy import linalg

from ...errors import NeedsPayload
from ..equations import Equations
from .compressed import Compressed, Estimate, solve
from .covariance import sandwich_with_gains
from .least_squares import weighted_solution


def require_payload(equations: Equations) -> None:
    """Raise unless currents were recorded and a known torque sets the scale of the gains.

    Raises:
        NeedsPayload: Torque was recorded, or no payload is known.
    """
    if equations.gain_known:
        raise NeedsPayload("torque was recorded, not current: there is no drive gain to identify")
    if not np.any(equations.known):
        raise NeedsPayload(
            "drive gains need a run with a known mass in addition to runs without it; "
            "give --payload RUN --mass KG"
        )


def homogeneous(compressed: Compressed, noise: np.ndarray) -> np.ndarray:
    """Compressed [V, W, P] of all joints, rows divided by their torque noise, shape (rows, n + b + 1)."""
    n = len(noise)
    blocks = []
    for joint in range(n):
        rows = compressed.factors[joint] / noise[joint]
        currents = np.zeros((len(rows), n))
        currents[:, joint] = rows[:, -1]
        blocks.append(np.column_stack([currents, -rows[:, :-1]]))
    return np.concatenate(blocks)


def _mixed(equations: Equations, compressed: Compressed) -> tuple[np.ndarray, np.ndarray]:
    """Values (b,) and gains (n,) by mixed LS-TLS with noise in the currents and an exact regressor."""
    n, gain = len(equations.gain), equations.gain
    floor = np.abs(gain) * equations.noise  # of each joint's torque, before any fit [N m]
    noise = np.where(np.isfinite(floor) & (floor > 0), floor, np.max(np.abs(gain)))
    for attempt in range(20):
        # Noise of each current column in weighted rows, as a root sum of squares [A/(N m)]: each row of a
        # joint has a noise of one over its gain; the other rows have none.
        gain_noise = np.sqrt(compressed.counts) / np.abs(gain)
        vector = _mixed_solution(homogeneous(compressed, noise), n, gain_noise)
        before, gain, values = gain, vector[:n], vector[n:-1]
        noise = compressed.residual_std(values, gain)
        # The first attempt uses weights of the noise floor.
        if attempt > 0 and np.max(np.abs(gain / before - 1)) < 1e-8:
            break
    return values, gain


def _mixed_solution(system: np.ndarray, n: int, gain_noise: np.ndarray) -> np.ndarray:
    """Solution (n + b + 1,): QR eliminates the exact columns, total least squares solves for the gains."""
    exact, noisy = system[:, n:], system[:, :n] / gain_noise
    size = np.linalg.norm(exact, axis=0)
    size[size == 0] = 1.0
    factor = linalg.qr(np.column_stack([exact / size, noisy]), mode="r")[0]
    count = exact.shape[1]
    right = linalg.svd(factor[count : count + n, count:])[2]
    gains = right[-1]
    values = linalg.solve_triangular(factor[:count, :count], -factor[:count, count:] @ gains) / size
    vector = np.concatenate([gains / gain_noise, values])
    return vector / vector[-1]


WIDE = 10.0
"""Relative prior standard deviation of a gain: so wide that it matters only if the data show nothing."""

FAR = 10.0
"""Limit of the ratio between the errors of stated gains; a gain beyond it counts as not observed."""

LOST = 1e4
"""Factor from stated gains beyond which no gain counts as observed; a mass in grams is a factor of 1000."""


def maximum_likelihood(equations: Equations) -> Estimate:
    """Gauss-Newton iteration from the mixed LS-TLS solution that re-estimates the noise of each joint."""
    require_payload(equations)
    compressed = Compressed.of(equations)
    values, gain = _start(equations, compressed)
    initial = gain
    for _ in range(50):
        noise = compressed.residual_std(values, gain) / np.abs(gain)
        labels = [*equations.names, *(f"drive gain {j + 1}" for j in range(len(noise)))]
        rows, right = linearised(compressed, values, 1.0 / gain, noise)
        loose = np.diag(-(gain**2) / (WIDE * np.abs(initial)))
        rows = np.concatenate([rows, np.pad(loose, ((0, 0), (len(values), 0)))])
        step = solve(rows, np.concatenate([right, (initial - gain) / (WIDE * np.abs(initial))]), labels)
        # Step in gains, not in their inverses: values that depend on an open gain stay multiples of it.
        change = -(gain**2) * step[len(values) :]
        values, gain = values + step[: len(values)], gain + change
        if np.max(np.abs(change / gain)) < 1e-10:
            break
    covariance = sandwich_with_gains(equations, values, gain, WIDE * initial)
    return Estimate("maximum likelihood", values, gain, covariance, compressed.residual_std(values, gain))


def _start(equations: Equations, compressed: Compressed) -> tuple[np.ndarray, np.ndarray]:
    """Initial values (b,) and gains (n,): the mixed LS-TLS solution, except for unobservable gains.

    If the payload causes no torque on a joint, the smallest singular vector may contain that joint alone,
    with an arbitrary gain, or no payload. Such a gain starts at its stated value, scaled as the other gains.
    """
    try:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            values, gain = _mixed(equations, compressed)
    except (np.linalg.LinAlgError, ValueError):
        return weighted_solution(equations, compressed)[0], equations.gain
    share = np.abs(gain / equations.gain)
    usual = float(share[np.argmin(np.abs(np.log(share)))])
    if not 1.0 / LOST < usual < LOST:
        return weighted_solution(equations, compressed)[0], equations.gain
    seen = (share > usual / FAR) & (share < usual * FAR)
    if np.all(seen) or np.all(equations.gain == 1.0):
        return values, gain
    gain = np.where(seen, gain, usual * equations.gain)
    return weighted_solution(replace(equations, gain=gain), compressed)[0], gain


def linearised(
    compressed: Compressed, values: np.ndarray, inverse: np.ndarray, noise: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Rows and right-hand side of a Gauss-Newton step in values (b,) and inverse gains (n,) [A/(N m)].

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


def literal(equations: Equations) -> Estimate:
    r"""Total least squares as in the paper's (12) to (21), without weights.

    The homogeneous system of (12), [V, -W, -P] [gain, values, 1] = rho, is solved by the right singular
    vector of the smallest singular value. This is optimal only if every entry of the matrix carries the same
    noise. It does not: currents of a few amperes stand beside columns of hundreds of rad/s^2, and joints
    differ in noise. The covariance (20) assumes white noise; with a colored residual, its intervals are too
    narrow.
    """
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
