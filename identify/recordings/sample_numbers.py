"""Numbers of samples taken at a constant rate: which were lost, and where the clock of the stamps was set.

Between two samples the stamps' earliest go on by one period, or by k of them where k - 1 samples were lost,
or by anything where the clock of the stamps was set. Positions decide: they jump where samples were lost.
"""

from typing import NamedTuple

import numpy as np
from scipy.ndimage import minimum_filter1d
from scipy.signal import find_peaks

SHORT = 0.5
"""A step of the stamps below so many periods is one within a burst."""
WIDTH = 20
"""Samples among which one is in time, at least."""
BURSTS = 4
"""Bursts among which one is in time."""
STRETCHES = 8
"""Stretches that a log has, at least."""
JUMP = 0.5
"""Periods by which the earliest stamps jump where samples were lost, or the clock stepped."""
RESOLVED = 1e-5
"""Noise of positions, at least [rad]; encoders resolve no less, and computed positions have none."""
VELOCITY = 4
"""Samples before and behind a jump over which velocities are taken."""
STILL = 1e-6
"""Way between two samples, over the noise of positions, that stands for none."""
SEEN = 8.0
"""Way that a jump of the stamps would mean, over the noise of positions, from which positions decide."""
ALIKE = 0.2
"""Share of that way, and of the velocity, within which positions go on as if no sample were missing."""
FEW = 4.0
"""Periods within which no motion turns around."""
STEPS = 2
"""How often a clock is set in a run, at most."""
PASSES = 20
"""Passes over the jumps; each corrects those that are far from each other."""


class Numbers(NamedTuple):
    """The numbers of samples.

    Attributes:
        number: From 0, shape (t,).
        offset: What the clock of the stamps was set by until each sample, shape (t,) [s].
        steps: Each of that: sample before which the clock was set, and by how much [s].
        lost: Samples that are missing.
        width: Samples among which one is in time.
    """

    number: np.ndarray
    offset: np.ndarray
    steps: tuple[tuple[int, float], ...]
    lost: int
    width: int


def number_samples(stamps: np.ndarray, values: np.ndarray) -> Numbers | None:
    """Numbers of samples with stamps (t,) [s] and values (t, n) that change evenly; None if unknown."""
    width = _width(stamps)
    while True:
        period = float(np.median(stamps[width:] - stamps[:-width])) / width
        if not period > 0.0:
            return None
        jump = _jumps(stamps - period * np.arange(len(stamps)), width) / period
        # Lost samples only ever add: where the earliest stamps go back often, more of them are needed.
        if len(find_peaks(-jump, JUMP, distance=2 * width)[0]) <= STEPS or 2 * STRETCHES * width > len(
            stamps
        ):
            return _numbered(stamps, values, period, width)
        width *= 2


def _width(stamps: np.ndarray) -> int:
    """Samples among which one is in time, by the bursts of stamps (t,) [s]."""
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
            # The earliest stamps go up where a sample was lost, or before that where stamps are late.
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
    """How values change from sample to sample, over their noise.

    Attributes:
        change: Shape (t - 1, n).
        velocity: Median of the changes before and behind each, shape (t - 1, n).
        turn: How far these two differ, shape (t - 1,).
    """

    change: np.ndarray
    velocity: np.ndarray
    turn: np.ndarray

    @classmethod
    def of(cls, values: np.ndarray) -> "Motion":
        """The motion of values (t, n)."""
        change = np.diff(values, axis=0)
        noise = 1.4826 * np.median(np.abs(np.diff(change, axis=0)), axis=0)
        change = change / np.maximum(noise, RESOLVED)
        padded = np.pad(change, ((VELOCITY, VELOCITY), (0, 0)), mode="edge")
        usual = np.median(np.lib.stride_tricks.sliding_window_view(padded, VELOCITY, axis=0), axis=-1)
        before, behind = usual[: len(change)], usual[VELOCITY + 1 :]
        return cls(change, 0.5 * (before + behind), np.linalg.norm(behind - before, axis=1))

    def lost(self, stretch: np.ndarray, by_stamps: int, size: float, known: np.ndarray) -> np.ndarray:
        """How many samples were lost at each place of a stretch.

        Args:
            stretch: Places between samples, shape (k,).
            by_stamps: The place in it at which the stamps jump.
            size: Jump of the earliest stamps, in periods.
            known: Steps of the numbers, shape (t - 1,).
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
        """Whether motion surely goes on between two samples; over a long gap it may turn around."""
        speed = float(np.linalg.norm(self.velocity[place]))
        way = float(np.linalg.norm(self.change[place] - self.velocity[place]))
        return speed * FEW > SEEN and max(way, self.turn[place]) < max(ALIKE * speed * FEW, SEEN)


def _jumps(late: np.ndarray, width: int) -> np.ndarray:
    """How far the earliest stamps rise from up to each sample to behind it, shape (t - 1,)."""
    before = minimum_filter1d(late, width, mode="constant", cval=np.inf, origin=width - 1 - width // 2)
    behind = minimum_filter1d(late, width, mode="constant", cval=np.inf, origin=-(width // 2))
    jump = np.asarray(behind[1:] - before[:-1])
    # At the ends, the earliest of few is no early one.
    jump[:width] = np.maximum(jump[:width], 0.0)
    jump[-width:] = np.minimum(jump[-width:], 0.0)
    return jump
