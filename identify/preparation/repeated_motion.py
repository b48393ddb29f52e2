"""Repeated motion: rows whose motion was made before, in the same run or in an earlier one.

What a model lacks depends on the motion, so it repeats with the motion. A lap that other laps predict tests
no model: all laps are left out together.
"""

from collections.abc import Hashable, Sequence

import numpy as np
from scipy import fft

SAME = 0.02
"""RMS difference of positions over their range, up to which a motion is the same [-]: a controller repeats a
motion to a few thousandths, and the torque then repeats to a few percent."""
OTHER = 0.1
"""RMS difference over the range above which two positions are different [-]: a lap leaves and comes back."""
OVERLAP = 0.25
"""Least share of a run that repeats an earlier motion."""


def first_rows(positions: Sequence[np.ndarray], kinds: Sequence[Hashable]) -> np.ndarray:
    """Row in which the motion of each row was made for the first time, shape (r,).

    Args:
        positions: Positions of each run (r, n) at a common rate; rows are counted over all runs.
        kinds: Kind of each run; a run repeats no run of another kind, as torque depends on the payload.
    """
    spread = np.ptp(np.concatenate(positions), axis=0)
    moving = spread > SAME * spread.max()
    scaled = [position[:, moving] / spread[moving] for position in positions]
    starts = np.cumsum([0, *map(len, positions)]).tolist()
    first = np.arange(starts[-1])
    for number, kind in enumerate(kinds):
        others = [place for place in range(number) if kinds[place] == kind]
        lags = {place: repeats_after(scaled[number], scaled[place]) for place in others}
        known = [place for place, lag in lags.items() if lag is not None][:1]
        for earlier in (*known, number):  # a lap of this run may repeat one that repeats an earlier run
            lag = lags[earlier] if earlier < number else laps_after(scaled[number])
            if lag is not None:
                stop = min(len(scaled[number]), int(len(scaled[earlier]) + lag))
                for row in range(int(np.ceil(max(lag, 0.0))), stop):
                    back = lag if earlier < number else lag * (row // lag)
                    first[starts[number] + row] = first[starts[earlier] + round(row - back)]
    return first


def repeated_share(residual: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Independent rows over all rows of each joint, shape (n,), where laps repeat a motion.

    A share of the residual repeats with the motion: it counts once, and noise counts in each lap. As for
    clusters of a sample, m rows with a correlation ρ count as m / (1 + (m - 1) ρ).

    Args:
        residual: Residual, zero where a row does not count, shape (r, n) [N m].
        first: Row in which the motion of each row was made for the first time, shape (r,).
    """
    share = np.ones(residual.shape[1])
    for joint, values in enumerate(residual.T):
        laps, squares = np.bincount(first, values != 0.0), np.bincount(first, values**2)
        products = np.bincount(first, values) ** 2 - squares
        correlation = max(products.sum() / max(float((laps - 1.0) @ squares), 1e-300), 0.0)
        if laps.any():  # some rows count
            share[joint] = np.sum(laps / (1.0 + np.maximum(laps - 1, 0) * correlation)) / laps.sum()
    return share


def repeats_after(later: np.ndarray, earlier: np.ndarray) -> float | None:
    """Number of rows by which a motion (r, n) follows an equal one (s, n); None if there is none.

    Positions are over their range. The number is negative if a run begins in the middle of the earlier one.
    """
    return _first_minimum(*_differences(later, earlier))


def laps_after(motion: np.ndarray) -> float | None:
    """Number of rows of a lap of a motion (r, n), whose positions are over their range; None for one lap."""
    lags, difference = _differences(motion, motion)
    # A slow motion resembles itself at short lags.
    away = np.flatnonzero((lags > 0) & (difference > OTHER))
    return _first_minimum(lags[away[0] :], difference[away[0] :]) if len(away) else None


def _first_minimum(lags: np.ndarray, difference: np.ndarray) -> float | None:
    """First lag, not a multiple of it, at which motions are the same."""
    below = np.flatnonzero(difference < SAME)
    if not len(below):
        return None
    end = below[0] + np.argmax(np.append(difference[below[0] :] >= SAME, True))
    return float(lags[below[0] + np.argmin(difference[below[0] : end])])


def _differences(later: np.ndarray, earlier: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lags at which enough rows of two motions (r, n) and (s, n) overlap, and their RMS difference there.

    A lap need not be a whole number of rows. The squared difference is a parabola about its minimum, so the
    vertex replaces a local minimum and its lag.
    """
    size = fft.next_fast_len(len(later) + len(earlier), real=True)
    shifts = np.arange(1 - len(earlier), len(later))

    def correlated(first: np.ndarray, second: np.ndarray) -> np.ndarray:
        spectrum = fft.rfft(first, size, axis=0) * np.conj(fft.rfft(second, size, axis=0))
        return np.asarray(fft.irfft(spectrum, size, axis=0)[shifts].sum(axis=1))

    overlap = np.rint(correlated(np.ones((len(later), 1)), np.ones((len(earlier), 1))))
    squares = correlated(later**2, np.ones_like(earlier)) + correlated(np.ones_like(later), earlier**2)
    enough = overlap >= OVERLAP * len(later)
    total = (squares - 2.0 * correlated(later, earlier))[enough] / overlap[enough]
    slope, bend = total[2:] - total[:-2], total[2:] + total[:-2] - 2.0 * total[1:-1]
    lowest = bend > np.abs(slope)
    total[1:-1][lowest] -= slope[lowest] ** 2 / (8.0 * bend[lowest])
    lags = shifts[enough].astype(float)
    lags[1:-1][lowest] -= slope[lowest] / (2.0 * bend[lowest])
    return lags, np.sqrt(np.maximum(total, 0.0) / max(later.shape[1], 1))
