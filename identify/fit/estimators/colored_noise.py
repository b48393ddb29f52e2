"""Colored noise: autocovariances of residuals, and their spectrum.

Current noise and residuals at 500 Hz are far from white, and they are correlated between joints.
"""

from collections.abc import Sequence

import numpy as np
from scipy import signal

from ..equations import Equations

MEMORY = 2.0
"""Longest lag of the residual's autocovariance [s]: several times the correlation time of noise and of
friction errors around a reversal, since Parzen's window reduces the values by a tenth at an eighth of the
longest lag."""


def noise_covariance(residual: np.ndarray, equations: Equations) -> np.ndarray:
    """Autocovariance of the residual (r, n) up to the lag `MEMORY`, without rows of zero weight."""
    pieces = [residual[run] for run in equations.runs]
    weights = [equations.weight[run] for run in equations.runs]
    lags = max(4, int(MEMORY * equations.rate))
    rows = float(np.mean(equations.weight.sum(axis=0)))
    return shrunk(autocovariance(pieces, weights, lags), max(rows, 1.0))


def autocovariance(pieces: Sequence[np.ndarray], weights: Sequence[np.ndarray], lags: int) -> np.ndarray:
    """Covariance of x(k) with x(k - lag) over pieces of signals (t, n), shape (lags + 1, n, n).

    Rows with zero weight count as zeros, and every lag is divided by the same number of rows. Unlike means
    over the rows of each lag, the sequence is then positive semi-definite for any gaps.
    """
    n = pieces[0].shape[1]
    products, counts = np.zeros((lags + 1, n, n)), np.zeros(n)
    for piece, weight in zip(pieces, weights, strict=True):
        masked = piece * weight
        counts += np.sum(weight**2, axis=0)
        for lag in range(min(lags + 1, len(piece))):
            products[lag] += masked[lag:].T @ masked[: len(piece) - lag]
    size = np.sqrt(np.maximum(counts, 1.0))
    return products / np.outer(size, size)


def spectrum(covariance: np.ndarray, count: int) -> np.ndarray:
    """Variance density at `count` or more even frequencies round the circle, shape (count, n, n).

    Autocovariances (lags + 1, n, n) are weighted by Parzen's window, which keeps the density positive
    semi-definite; its mean over the circle is the covariance at lag zero.
    """
    lags = len(covariance) - 1
    count = max(count, 2 * lags + 1)
    window = signal.windows.parzen(2 * lags + 1)[lags:]
    sequence = np.zeros((count, *covariance.shape[1:]))
    sequence[: lags + 1] = window[:, None, None] * covariance
    sequence[count - lags :] = np.swapaxes(sequence[lags:0:-1], 1, 2)
    return np.fft.fft(sequence, axis=0)


PARZEN = 0.539
"""Variance of a density at one frequency, over its square and over lags per row, for Parzen's window
(Priestley 1981, table 6.1)."""


def shrunk(covariance: np.ndarray, rows: float) -> np.ndarray:
    r"""Autocovariances (lags + 1, n, n) from a number of rows, with their chance correlations reduced.

    Independent signals of finite length seem correlated. The variance of each cross spectrum,
    :math:`v\,S_{ii} S_{jj}` with v = `PARZEN` * lags / rows, adds up over the pairs of seven joints: the
    combinations with least noise then seem up to 40 % less noisy than they are. All cross covariances are
    multiplied by the factor with the least mean squared error, as Ledoit and Wolf (2004) do for covariances.
    """
    lags, n = len(covariance) - 1, covariance.shape[1]
    size = np.sqrt(np.maximum(np.diagonal(covariance[0]), np.finfo(float).tiny))
    density = spectrum(covariance / np.outer(size, size), 1)
    power = np.diagonal(density, axis1=1, axis2=2).real
    between = ~np.eye(n, dtype=bool)
    chance = PARZEN * lags / rows * np.sum((power.T @ power)[between])
    seen = np.sum(np.abs(density[:, between]) ** 2)
    share = max(0.0, 1.0 - chance / seen) if seen > 0.0 else 0.0
    return covariance * np.where(between, share, 1.0)
