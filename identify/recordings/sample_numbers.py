"""Numbers of samples at a constant rate: lost samples, and settings of the clock of the time stamps.

Between two samples, the earliest stamps advance by one period, by k periods if k - 1 samples were lost, or by
any time if the clock of the stamps was set. Positions show which: they jump if samples were lost.
"""

from typing import NamedTuple

import numpy as np
from scipy.ndimage import minimum_filter1d
from scipy.signal import find_peaks

SHORT = 0.5
"""Maximum step of the stamps within a burst, in periods."""
WIDTH = 20
"""Minimum number of samples of which one is on time."""
BURSTS = 4
"""Number of bursts of which one is on time."""
STRETCHES = 8
"""Minimum number of stretches in a log."""
JUMP = 0.5
"""Minimum jump of the earliest stamps, in periods, if samples were lost or the clock was set."""
RESOLVED = 1e-5
"""Minimum noise of positions [rad]: the resolution of encoders; computed positions have none."""
VELOCITY = 4
"""Number of samples before and behind a jump over which velocities are computed."""
STILL = 1e-6
"""Distance between two samples, over the noise of positions, that stands for zero."""
SEEN = 8.0
"""Distance during a jump of the stamps, over the noise of positions, from which positions decide."""
ALIKE = 0.2
"""Share of that distance, and of the velocity, within which positions continue without a missing sample."""
FEW = 4.0
"""Number of periods within which no motion reverses."""
STEPS = 2
"""Maximum number of times a clock is set in a run."""
PASSES = 20
"""Maximum number of passes over the jumps; each corrects those that are far from each other."""


class Numbers(NamedTuple):
    """Numbers of samples."""

    number: np.ndarray  # number of each sample from 0, shape (t,)
    offset: np.ndarray  # total adjustment of the clock of the stamps until each sample, shape (t,) [s]
    # Adjustments of the clock: the sample that follows, and the step [s].
    steps: tuple[tuple[int, float], ...]
    lost: int  # number of missing samples
    width: int  # number of samples of which one is on time


def number_samples(stamps: np.ndarray, values: np.ndarray) -> Numbers | None:
    """Numbers of samples with stamps (t,) [s] and values (t, n) that change evenly; None if unknown."""
    width = _width(stamps)
    while True:
        period = float(np.median(stamps[width:] - stamps[:-width])) / width
        if not period > 0.0:
            return None
        jump = _jumps(stamps - period * np.arange(len(stamps)), width) / period
        # Lost samples never make stamps go back: if the earliest stamps often do, the window is too short.
        if len(find_peaks(-jump, JUMP, distance=2 * width)[0]) <= STEPS or 2 * STRETCHES * width > len(
            stamps
        ):
            return _numbered(stamps, values, period, width)
        width *= 2


def _width(stamps: np.ndarray) -> int:
    """Number of samples of which one is on time, from the bursts of stamps (t,) [s]."""
    steps = np.diff(stamps)
    usual = steps[steps <= np.percentile(steps, 99.5)]
    short = steps < SHORT * float(usual.mean())
    edges = np.flatnonzero(np.diff(np.concatenate([[0], short, [0]])))
    longest = int(np.percentile(edges[1::2] - edges[::2], 95)) + 1 if short.any() else 1
    return min(max(WIDTH, BURSTS * longest), max(len(stamps) // STRETCHES, 2))


def _numbered(stamps: np.ndarray, values: np.ndarray, period: float, width: int) -> Numbers:
    number, offset, steps = np.arange(len(stamps)), np.zeros(len(stamps)), []
    motion = Motion.of(values)
    settled = np.zeros(len(stamps) - 1, bool)
    for _ in range(PASSES):
        jump = _jumps(stamps - offset - period * number, width) / period
        jump[settled] = 0.0
        places = find_peaks(np.abs(jump), JUMP, distance=2 * width)[0]
        for place in places:
            # The earliest stamps rise at a lost sample, or before it if stamps are late.
            ends = np.array([-width, 0] if jump[place] > 0.0 else [0, width]) + place
            stretch = np.arange(max(ends[0] - width // BURSTS, 0), min(ends[1] + width // BURSTS, len(jump)))
            by_stamps = int(stretch[np.argmax(jump[place] * np.diff(stamps)[stretch])])
            lost = motion.lost(stretch, by_stamps, float(jump[place]), np.diff(number))
            number[1:] += np.cumsum(np.bincount(stretch, lost, len(jump))).astype(int)
            if lost.any():
                continue
            settled[stretch] = True
            if abs(jump[place]) > FEW and motion.goes_on(by_stamps):
                offset[by_stamps + 1 :] += jump[place] * period
                steps.append((by_stamps + 1, float(jump[place] * period)))
        if not len(places):
            break
    return Numbers(number, offset, tuple(sorted(steps)), int(number[-1]) + 1 - len(number), width)


class Motion(NamedTuple):
    """Change of values from sample to sample, over their noise."""

    change: np.ndarray  # changes, shape (t - 1, n)
    velocity: np.ndarray  # mean of the median changes before and behind each change, shape (t - 1, n)
    turn: np.ndarray  # difference of these two medians, shape (t - 1,)

    @classmethod
    def of(cls, values: np.ndarray) -> "Motion":
        """Motion of values (t, n)."""
        change = np.diff(values, axis=0)
        noise = 1.4826 * np.median(np.abs(np.diff(change, axis=0)), axis=0)
        change = change / np.maximum(noise, RESOLVED)
        padded = np.pad(change, ((VELOCITY, VELOCITY), (0, 0)), mode="edge")
        usual = np.median(np.lib.stride_tricks.sliding_window_view(padded, VELOCITY, axis=0), axis=-1)
        before, behind = usual[: len(change)], usual[VELOCITY + 1 :]
        return cls(change, 0.5 * (before + behind), np.linalg.norm(behind - before, axis=1))

    def lost(self, stretch: np.ndarray, by_stamps: int, size: float, known: np.ndarray) -> np.ndarray:
        """Number of lost samples at each place (k,) of a stretch between samples.

        The stamps jump at the place `by_stamps`, the earliest by `size` in periods; `known` (t - 1,) are the
        steps of the numbers.
        """
        velocity, none = self.velocity[stretch], np.zeros(len(stretch), int)
        speed = np.maximum(np.linalg.norm(velocity, axis=1), STILL)
        extra = self.change[stretch] - velocity * known[stretch, None]
        seen = np.where(speed > SEEN, np.sum(extra * velocity, axis=1) / speed**2, 0.0)
        counts = np.maximum(np.round(seen), 0).astype(int)
        if size > 0.0 and counts.sum() == round(size) and counts.max() < FEW:
            return counts
        at_stamps = np.where(stretch == by_stamps, max(round(size), 0), 0)
        if np.median(speed) * abs(size) < SEEN:
            return at_stamps
        if 0.0 < size < FEW:
            return np.where(np.arange(len(stretch)) == np.argmax(seen), counts, 0)
        return none if self.goes_on(by_stamps) else at_stamps

    def goes_on(self, place: int) -> bool:
        """Whether motion certainly continues between two samples; over a long gap it may reverse."""
        speed = float(np.linalg.norm(self.velocity[place]))
        extra = float(np.linalg.norm(self.change[place] - self.velocity[place]))
        return speed * FEW > SEEN and max(extra, self.turn[place]) < max(ALIKE * speed * FEW, SEEN)


def _jumps(late: np.ndarray, width: int) -> np.ndarray:
    """Rise of the earliest stamps from before each place to behind it, shape (t - 1,)."""
    before = minimum_filter1d(late, width, mode="constant", cval=np.inf, origin=width - 1 - width // 2)
    behind = minimum_filter1d(late, width, mode="constant", cval=np.inf, origin=-(width // 2))
    jump = np.asarray(behind[1:] - before[:-1])
    # At the ends, the earliest of a few stamps may be late.
    jump[:width] = np.maximum(jump[:width], 0.0)
    jump[-width:] = np.minimum(jump[-width:], 0.0)
    return jump
