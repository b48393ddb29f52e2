r"""Estimates of drive gains and dynamics together, from runs with and without a known payload.

Total least squares: the homogeneous system of the paper's (12), [V, -W, -P] [gain, values, 1] = rho, is
solved by the right singular vector of the smallest singular value. That is the best estimate only if every
entry of the matrix carries the same noise. Taken literally it does not: a current of amperes stands beside
columns of hundreds of rad/s^2, and joints differ in noise. `literal` shows what follows. `total` divides each
joint's rows by its torque noise and each column by its own noise; `mixed` takes that to the limit in which
the regressor is exact (Van Huffel and Vandewalle, the mixed LS-TLS problem).

`literal` and `total` report the paper's covariance (20), which takes rows for white; where a residual is
coloured their intervals are too short. `mixed` reports the one of `covariance`.

Maximum likelihood: noise sits in the currents, so they are what is predicted:
:math:`\sum_j \| i_j - \gamma_j (W_j \chi + P_j) \|^2 / \sigma_j^2` with :math:`\gamma_j = 1/g_j`. Unlike
least squares in torque, where noisy currents are regressors and pull the gains down, it is unbiased.
"""

from dataclasses import replace

import numpy as np
from scipy import linalg

from ...errors import NeedsPayload
from ..equations import Equations
from .compressed import Compressed, Estimate, solve
from .covariance import sandwich_with_gains
from .least_squares import weighted_solution


def literal(equations: Equations) -> Estimate:
    """Total least squares exactly as in the paper's (12) to (21), without weights."""
    ones = np.ones(len(equations.gain))
    system = _homogeneous(equations, Compressed.of(equations), ones)
    return _total("literal", equations, system, np.ones(system.shape[1]))


def total(equations: Equations) -> Estimate:
    """Total least squares with rows and columns weighted by their noise."""
    compressed = Compressed.of(equations)
    estimate = mixed(equations)
    encoder = equations.regressor_noise() if equations.regressor_noise else None
    for _ in range(3):  # the weights need the gains, roughly
        system = _homogeneous(equations, compressed, estimate.noise)
        columns = _column_noise(equations, estimate.noise, estimate.gain, encoder)
        estimate = _total("total", equations, system, columns)
    return estimate


def mixed(equations: Equations) -> Estimate:
    """Mixed LS-TLS: noise in the currents, none in the regressor."""
    require_payload(equations)
    compressed = Compressed.of(equations)
    n = len(equations.gain)
    noise, gain = _nominal_noise(equations), equations.gain
    for attempt in range(20):
        system = _homogeneous(equations, compressed, noise)
        vector = _mixed_solution(system, n, _gain_column_noise(compressed.counts, gain))
        before, gain, values = gain, vector[:n], vector[n:-1]
        noise = compressed.residual_std(values, gain)
        if attempt > 0 and np.max(np.abs(gain / before - 1)) < 1e-8:  # the first has the floor's weights
            break
    # Its estimating equations are, to first order, those of maximum likelihood in the currents.
    return Estimate("mixed", values, gain, sandwich_with_gains(equations, values, gain), noise)


def require_payload(equations: Equations) -> None:
    """Raise unless currents were recorded and some torque is known, which alone sets the gains' scale.

    Raises:
        NeedsPayload: Torque was recorded, or nothing about a payload is known.
    """
    if equations.gain_known:
        raise NeedsPayload("torque was recorded, not current: there is no drive gain to identify")
    if not np.any(equations.known):
        raise NeedsPayload(
            "drive gains need a run that carries a known mass beside runs without it; "
            "give --payload RUN --mass KG"
        )


def _homogeneous(equations: Equations, compressed: Compressed, noise: np.ndarray) -> np.ndarray:
    """Compressed [V, W, P] of all joints, rows divided by their torque noise, shape (rows, n + b + 1)."""
    n = len(equations.gain)
    blocks = []
    for joint in range(n):
        rows = compressed.factors[joint] / noise[joint]
        currents = np.zeros((len(rows), n))
        currents[:, joint] = rows[:, -1]
        blocks.append(np.column_stack([currents, -rows[:, :-1]]))
    return np.concatenate(blocks)


def _nominal_noise(equations: Equations) -> np.ndarray:
    """Noise of each joint's torque before any fit: the floor's times the nominal gain, (n,) [N m]."""
    floor = np.abs(equations.gain) * equations.noise
    return np.where(np.isfinite(floor) & (floor > 0), floor, np.max(np.abs(equations.gain)))


def _gain_column_noise(counts: np.ndarray, gain: np.ndarray) -> np.ndarray:
    """Noise of each current column in weighted rows, as a root sum of squares, shape (n,) [A/(N m)].

    Each of a joint's rows, `counts` (n,) of them, has a noise of one over its gain; others have none.
    """
    return np.sqrt(counts) / np.abs(gain)


def _column_noise(
    equations: Equations, noise: np.ndarray, gain: np.ndarray, encoder: np.ndarray | None
) -> np.ndarray:
    """Noise of each column of [V, W, P] in weighted rows, as a root sum of squares, shape (n + b + 1,)."""
    counts = equations.weight.sum(axis=0)
    columns = np.concatenate([equations.regressor, equations.known[:, :, None]], axis=2)
    size = np.sqrt(np.einsum("rnb,rn->b", columns**2, equations.weight / noise**2))
    # A constant column has no noise; a millionth of it keeps the singular values within double precision.
    floor = 1e-6 * size
    if encoder is not None:
        floor = np.maximum(floor, np.sqrt((counts / noise**2) @ encoder**2))
    return np.concatenate([_gain_column_noise(counts, gain), floor])


def _total(method: str, equations: Equations, system: np.ndarray, column_noise: np.ndarray) -> Estimate:
    """The paper's (16) to (21) on columns divided by their noise."""
    require_payload(equations)
    compressed, n = Compressed.of(equations), len(equations.gain)
    scaled = system / column_noise
    _, singular, right = linalg.svd(scaled, full_matrices=False)
    last = right[-1]
    vector = last / column_noise
    vector = vector / vector[-1]
    unknowns = last[:-1] / last[-1]  # in the scaled columns, where (20) holds
    deviation = singular[-1] / np.sqrt(compressed.counts.sum() - scaled.shape[1])
    compatible = scaled - np.outer(scaled @ last, last)
    gram = compatible[:, :-1].T @ compatible[:, :-1]
    covariance = deviation**2 * (1 + unknowns @ unknowns) * np.linalg.pinv(gram, hermitian=True)
    back = column_noise[-1] / column_noise[:-1]
    covariance = covariance * np.outer(back, back)
    order = np.concatenate([np.arange(n, len(covariance)), np.arange(n)])
    values, gain = vector[n:-1], vector[:n]
    noise = compressed.residual_std(values, gain)
    return Estimate(method, values, gain, covariance[np.ix_(order, order)], noise)


def _mixed_solution(system: np.ndarray, n: int, gain_noise: np.ndarray) -> np.ndarray:
    """Eliminate the exact columns by QR, then total least squares on the currents alone."""
    exact, noisy = system[:, n:], system[:, :n] / gain_noise
    size = np.linalg.norm(exact, axis=0)
    size[size == 0] = 1.0
    factor = linalg.qr(np.column_stack([exact / size, noisy]), mode="r")[0]
    count = exact.shape[1]
    right = linalg.svd(factor[count : count + n, count:])[2]
    gains = right[-1]
    rest = linalg.solve_triangular(factor[:count, :count], -factor[:count, count:] @ gains) / size
    vector = np.concatenate([gains / gain_noise, rest])
    return vector / vector[-1]


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
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            found = mixed(equations)
        values, gain = found.values, found.gain
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
