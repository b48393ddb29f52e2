"""Repeated motion: rows whose motion was made before, in the same run or in an earlier one.

What a model lacks depends on the motion, so it repeats with the motion. A lap that other laps predict tests
no model: all laps are left out together.
"""

from collections.abc import Sequence

import numpy as np
from scipy import fft

from ..runs.driven import Driven, slices

SAME = 0.02
"""RMS difference of positions over their range, up to which a motion is the same [-]: a controller repeats a
motion to a few thousandths, and the torque then repeats to a few percent."""
OTHER = 0.1
"""RMS difference over the range above which two positions are different [-]: a lap leaves and comes back."""
OVERLAP = 0.25
"""Least share of a run that repeats an earlier motion."""


def first_rows(runs: Sequence[Driven]) -> np.ndarray:
    """Row in which the motion of each row was made for the first time, shape (r,).

    Runs of another role or payload are no earlier motion: held-out runs test the fit of the others, and
    torque depends on the payload.
    """
    positions = [run.motion.position[run.centres] for run in runs]
    spread = np.ptp(np.concatenate(positions), axis=0)
    moving = spread > SAME * spread.max()
    scaled = [position[:, moving] / spread[moving] for position in positions]
    kinds = [(run.role, run.motion.payload) for run in runs]
    rows, first = slices(runs), np.arange(sum(map(len, positions)))
    for number, kind in enumerate(kinds):
        others = [place for place in range(number) if kinds[place] == kind]
        lags = {place: repeats_after(scaled[number], scaled[place]) for place in others}
        known = [place for place, lag in lags.items() if lag is not None][:1]
        for earlier in (*known, number):  # a lap of this run may repeat one that repeats an earlier run
            lag = lags[earlier] if earlier < number else laps_after(scaled[number])
            if lag is not None:
                later = np.arange(max(lag, 0), min(len(scaled[number]), len(scaled[earlier]) + lag))
                for row in later.tolist():
                    first[rows[number].start + row] = first[rows[earlier].start + row - lag]
    return first


def repeats_after(later: np.ndarray, earlier: np.ndarray) -> int | None:
    """Number of rows by which a motion (r, n) follows an equal one (s, n); None if there is none.

    Positions are over their range. The number is negative if a run begins in the middle of the earlier one.
    """
    return _first_minimum(*_differences(later, earlier))


def laps_after(motion: np.ndarray) -> int | None:
    """Number of rows of a lap of a motion (r, n), whose positions are over their range; None for one lap."""
    lags, difference = _differences(motion, motion)
    # A slow motion resembles itself at short lags.
    away = np.flatnonzero((lags > 0) & (difference > OTHER))
    return _first_minimum(lags[away[0] :], difference[away[0] :]) if len(away) else None


def _first_minimum(lags: np.ndarray, difference: np.ndarray) -> int | None:
    """First lag, not a multiple of it, at which motions are the same."""
    below = np.flatnonzero(difference < SAME)
    if not len(below):
        return None
    end = below[0] + np.argmax(np.append(difference[below[0] :] >= SAME, True))
    return int(lags[below[0] + np.argmin(difference[below[0] : end])])


def _differences(later: np.ndarray, earlier: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lags at which enough rows of two motions (r, n) and (s, n) overlap, and their RMS difference there."""
    size = fft.next_fast_len(len(later) + len(earlier), real=True)
    lags = np.arange(1 - len(earlier), len(later))

    def correlated(first: np.ndarray, second: np.ndarray) -> np.ndarray:
        spectrum = fft.rfft(first, size, axis=0) * np.conj(fft.rfft(second, size, axis=0))
        return np.asarray(fft.irfft(spectrum, size, axis=0)[lags].sum(axis=1))

    overlap = np.rint(correlated(np.ones((len(later), 1)), np.ones((len(earlier), 1))))
    squares = correlated(later**2, np.ones_like(earlier)) + correlated(np.ones_like(later), earlier**2)
    enough = overlap >= OVERLAP * len(later)
    total = (squares - 2.0 * correlated(later, earlier))[enough]
    return lags[enough], np.sqrt(np.maximum(total, 0.0) / (overlap[enough] * max(later.shape[1], 1)))
