"""Stamps that tell when a sample arrived, and the regular clock by which it was taken.

A sensor that samples at a constant rate is often stamped by the receiver of its messages: late, in bursts,
or with few digits. Its positions then change evenly from sample to sample, and unevenly over the stamps. The
clock is the line through the earliest stamps: no message arrives before it is sent.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..schema import LARGEST
from .recording import EFFORT, Recording, Signal
from .sample_numbers import RESOLVED, STEPS, number_samples

FEWEST = 50
"""Samples in motion from which a clock can be judged."""
MOVES = 3.0
"""Change of a position between samples, over its noise, from which a joint moves."""
ASTRAY = 10.0
"""Misfit of a sample, over the noise, that is a glitch by either clock."""
MATTERS = 0.5
"""Misfit that the stamps' jitter causes in a sample, over the noise, from which on it matters."""
LITTLE = 0.02
"""Jitter that no clock is replaced for, in periods: the velocity between two samples is as wrong."""
OFTEN = 0.02
"""Share of the samples in motion in which it matters, at least: a single step is no jitter."""
SURE = 0.05
"""Standard deviation of the share of the jitter that is real, at most."""
REAL, UNREAL = 0.8, 0.2
"""Shares of the jitter that is real, from which stamps are true and up to which they are times of arrival."""
STRAIGHT = 0.5
"""How far the earliest stamps of a stretch may lie off one line, in periods; then numbers are unclear."""
LOST = 0.1
"""Share of samples that may be lost; with more of them, their number is unclear."""
EVENER = 0.7
"""Misfit of positions by true stamps, over that by a regular clock, at most."""
OPTION = "state it (--rate HZ)"
DIGITS = (1.0, 0.1, 0.01, 0.001)
"""Resolutions of rounded stamps [s]."""


class Clock(NamedTuple):
    """What the stamps of one signal are.

    Attributes:
        time: Regular times of the samples, shape (t,) [s].
        period: Of the samples [s].
        late: Mean delay of the stamps against it, and the largest [s].
        kind: What the stamps look like, in words; "" where they agree with the clock.
        certain: Whether the samples were surely taken by this clock.
        steps: When the clock of the stamps was set: sample before which, and by how much [s].
        missing: Samples that were lost.
    """

    time: np.ndarray
    period: float
    late: tuple[float, float]
    kind: str
    certain: bool
    steps: tuple[tuple[int, float], ...] = ()
    missing: int = 0

    @property
    def what(self) -> str:
        """What the stamps are, in words."""
        return f"stamps {self.kind}" if self.kind else "stamps are of a clock that was set"

    def facts(self, stamps: np.ndarray) -> Iterator[str]:
        """What stamps (t,) [s] are and what was done about it, in sentences."""
        doubt = (
            "" if self.certain else f". Their clock is unclear: they are kept; if the rate is known, {OPTION}"
        )
        for sample, seconds in self.steps:
            yield (
                f"the clock of the stamps was set by {seconds:+.3f} s at {stamps[sample - 1]:.3f} s, while "
                f"the motion goes on{doubt or '; that is undone'}"
            )
        if self.kind:
            lost = f", which {self.missing} samples lack" if self.missing else ""
            done = f". A regular clock of {1e3 * self.period:.4f} ms through the earliest replaces them{lost}"
            late = f", {1e3 * self.late[0]:.3g} ms on average and {1e3 * self.late[1]:.3g} ms at most"
            yield (
                f"stamps {self.kind}{late * self.certain}, while the motion goes on evenly from sample to "
                f"sample{doubt or done}"
            )


def with_regular_clocks(recording: Recording) -> Recording:
    """The recording on the clocks by which its samples were taken, with a warning of what was done."""
    signals, warnings = dict(recording.signals), []
    for names in signals_by_stamps(recording):
        judged = next((name for name in ("position", "velocity", *EFFORT) if name in names), names[0])
        clock = regular_clock(signals[judged].time, signals[judged].values)
        if clock is None:
            continue
        warnings += [f"{', '.join(names)}: {fact}" for fact in clock.facts(signals[judged].time)]
        if clock.certain:
            signals |= {name: Signal(clock.time, signals[name].values) for name in names}
    earliest = min((float(signal.time[0]) for signal in signals.values() if len(signal)), default=0.0)
    if warnings and earliest < 0.0:  # the first message was late; files keep no time before the start
        signals = {name: Signal(signal.time - earliest, signal.values) for name, signal in signals.items()}
    return replace(recording, signals=signals).with_warnings(*warnings)


def signals_by_stamps(recording: Recording) -> list[list[str]]:
    """Names of the signals, those that share their time stamps together."""
    sharing: dict[bytes, list[str]] = {}
    for name, signal in recording.signals.items():
        sharing.setdefault(signal.time.tobytes(), []).append(name)
    return list(sharing.values())


def regular_clock(stamps: np.ndarray, values: np.ndarray) -> Clock | None:
    """The regular clock of samples whose stamps are not their times; None where the stamps may be true.

    Args:
        stamps: Shape (t,) [s].
        values: What changes evenly, positions best, shape (t, n); NaN where unknown.
    """
    values = values[:, (np.abs(values) < LARGEST).all(axis=0)]
    if len(stamps) < FEWEST or not values.size or not np.isfinite(stamps).all():
        return None
    if _true(stamps, values):
        return None
    numbers = number_samples(stamps, values)
    if numbers is None:
        return None
    time, straight = _envelope(stamps - numbers.offset, numbers.number, numbers.width)
    late = stamps - numbers.offset - time
    step = float((time[-1] - time[0]) / (numbers.number[-1] - numbers.number[0]))
    share, std, often = _real_share(late / step, numbers.number, values)
    arrivals = often > OFTEN and share < REAL and float(np.std(late)) > LITTLE * step
    apart = np.diff([0, *(sample for sample, _ in numbers.steps), len(stamps)])
    settled = len(numbers.steps) <= STEPS and bool(np.all(apart >= FEWEST))
    if not arrivals and not (numbers.steps and settled):
        return None
    certain = straight and settled and numbers.lost <= LOST * len(stamps)
    certain = certain and (not arrivals or (share < UNREAL and std < SURE))
    if not arrivals:  # of a clock that only steps, the stamps are true
        time = stamps - numbers.offset
    kind = _kind(stamps, step) if arrivals else ""
    return Clock(
        time, step, (float(late.mean()), float(late.max())), kind, certain, numbers.steps, numbers.lost
    )


def _true(stamps: np.ndarray, values: np.ndarray) -> bool:
    """Whether values (t, n) change more evenly over the stamps (t,) than from sample to sample."""
    with np.errstate(all="ignore"):  # stamps may repeat
        by_stamps = _spread(_misfit(values, _cubic(stamps)))
    by_number = _spread(_misfit(values, _cubic(np.arange(len(stamps), dtype=float))))
    return bool(np.any(by_stamps < EVENER * by_number))


def _envelope(stamps: np.ndarray, number: np.ndarray, width: int) -> tuple[np.ndarray, bool]:
    """Times on the line through the earliest stamps (t,) of each stretch, and whether these are on a line."""
    count = max(len(stamps) // width, 2)
    slope = np.polyfit(number, stamps, 1)[0]
    for _ in range(2):  # which stamp is the earliest depends on the slope
        stretches = np.array_split(np.arange(len(stamps)), count)
        places = np.array([rows[np.argmin((stamps - slope * number)[rows])] for rows in stretches])
        slope, start = np.polyfit(number[places], stamps[places], 1)
    off = stamps[places] - slope * number[places] - start
    return slope * number + start, bool(np.std(off) < STRAIGHT * slope)


def _real_share(late: np.ndarray, number: np.ndarray, values: np.ndarray) -> tuple[float, float, float]:
    """Share of the stamps' jitter that is real, its standard deviation, and how often it matters.

    A position lies on a cubic through its neighbors, by the clock by which it was taken. By the regular clock
    it misses that by what jitter moves it, if the jitter is real, and by nothing if it is not.

    Args:
        late: Delay of the stamps against the regular clock, in its periods, shape (t,).
        number: Numbers of the samples, shape (t,).
        values: Shape (t, n).

    Returns:
        The last is the share of the samples in motion in which jitter matters.
    """
    weights = _cubic(number.astype(float))
    velocity = (values[4:] - values[:-4]) / (number[4:] - number[:-4])[:, None]
    off = _misfit(values, weights)
    moved = _misfit(late[:, None], weights) * velocity
    noise = np.minimum(_spread(off), _spread(off - moved))
    used = (np.abs(velocity) > MOVES * noise) & (
        np.minimum(np.abs(off), np.abs(off - moved)) < ASTRAY * noise
    )
    if used.sum() < FEWEST:
        return 1.0, 1.0, 0.0
    often = np.mean((np.abs(moved) > MATTERS * noise)[used.any(axis=1)].any(axis=1))
    off, moved = (off / noise)[used], (moved / noise)[used]
    power = max(float(moved @ moved), np.finfo(float).tiny)
    share = float(off @ moved) / power
    rest = off - share * moved
    return share, float(np.sqrt(rest @ rest / len(rest) / power)), float(often)


def _cubic(number: np.ndarray) -> np.ndarray:
    """Weights of the two neighbors to each side in the cubic through them, shape (t - 4, 4)."""
    inner = number[2:-2]
    nodes = np.stack([number[:-4], number[1:-3], number[3:-1], number[4:]], axis=1) - inner[:, None]
    weights = np.ones_like(nodes)
    for node in range(4):
        for other in set(range(4)) - {node}:
            weights[:, node] *= nodes[:, other] / (nodes[:, other] - nodes[:, node])
    return weights


def _misfit(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """How far each inner value lies from its neighbors' cubic, shape (t - 4, n)."""
    neighbors = np.stack([values[:-4], values[1:-3], values[3:-1], values[4:]], axis=1)
    return np.asarray(values[2:-2] - np.einsum("tk,tkn->tn", weights, neighbors))


def _spread(values: np.ndarray) -> np.ndarray:
    """Standard deviation of most values of each column, and at least that of an encoder, shape (n,)."""
    return np.maximum(1.4826 * np.median(np.abs(values), axis=0), RESOLVED)


def _kind(stamps: np.ndarray, period: float) -> str:
    """What stamps (t,) [s] that are times of arrival look like."""
    steps = np.diff(stamps)
    for digit in DIGITS:
        if np.all(np.abs(steps / digit - np.round(steps / digit)) < 1e-3):
            return f"are rounded to {1e3 * digit:g} ms and wrong by that"
    short = steps < 0.25 * period
    if np.mean(short) > 0.3:
        return f"are times of arrival, in bursts of about {1.0 / (1.0 - np.mean(short)):.2g}, late"
    return "are times of arrival, late by varying delays"
