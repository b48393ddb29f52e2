"""Time stamps of the arrival of samples, and the regular clock by which the samples were taken.

The receiver of messages often stamps the samples of a sensor with a constant rate: late, in bursts, or with
few digits. Positions then change evenly from sample to sample, but unevenly over the stamps. The clock is the
line through the earliest stamps, since no message arrives before it is sent.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..schema import LARGEST
from .recording import EFFORT, Recording, Signal
from .sample_numbers import RESOLVED, STEPS, number_samples

FEWEST = 50
"""Minimum number of samples in motion to judge a clock."""
MOVES = 3.0
"""Minimum change of a moving position between samples, over its noise."""
ASTRAY = 10.0
"""Residual of a sample, over the noise, from which it is a glitch for either clock."""
MATTERS = 0.5
"""Residual due to jitter of the stamps, over the noise, from which the jitter matters."""
LITTLE = 0.02
"""Jitter that is tolerated, in periods: it changes the velocity between two samples by this share."""
OFTEN = 0.02
"""Minimum share of the samples in motion in which jitter matters: a single step is not jitter."""
SURE = 0.05
"""Maximum standard deviation of the share of the jitter that is real."""
REAL, UNREAL = 0.8, 0.2
"""Share of real jitter above which stamps are true, and below which they are times of arrival."""
STRAIGHT = 0.5
"""Maximum scatter of the earliest stamps about a line, in periods; beyond it, sample numbers are unclear."""
LOST = 0.1
"""Maximum share of lost samples; beyond it, sample numbers are unclear."""
EVENER = 0.7
"""Maximum ratio of the residuals of positions over true stamps to those over a regular clock."""
OPTION = "state it (--rate HZ)"
DIGITS = (1.0, 0.1, 0.01, 0.001)
"""Resolutions of rounded stamps [s]."""


class Clock(NamedTuple):
    """Regular clock of the samples of one signal."""

    time: np.ndarray  # regular times of the samples, shape (t,) [s]
    period: float  # sampling period [s]
    late: tuple[float, float]  # mean and maximum delay of the stamps behind the clock [s]
    kind: str  # description of the stamps; "" if they agree with the clock
    certain: bool  # whether it is certain that the samples were taken by this clock
    # Adjustments of the clock of the stamps: the sample that follows, and the step [s].
    steps: tuple[tuple[int, float], ...] = ()
    missing: int = 0  # number of lost samples

    def facts(self, stamps: np.ndarray) -> Iterator[str]:
        """Sentences about the stamps (t,) [s] and their correction."""
        doubt = (
            "" if self.certain else f". Their clock is unclear: they are kept; if the rate is known, {OPTION}"
        )
        if self.steps:
            steps = ", ".join(f"{size:+.3f} s at {stamps[sample - 1]:.3f} s" for sample, size in self.steps)
            yield (
                f"the clock of the stamps was set by {steps}, while the motion continues"
                f"{doubt or '; the step was removed'}"
            )
        if self.kind:
            lost = f", which {self.missing} samples lack" if self.missing else ""
            done = f". A regular clock of {1e3 * self.period:.4f} ms through the earliest replaces them{lost}"
            late = f", {1e3 * self.late[0]:.3g} ms on average and {1e3 * self.late[1]:.3g} ms at most"
            yield (
                f"stamps {self.kind}{late * self.certain}, while the motion is even from sample to "
                f"sample{doubt or done}"
            )


def with_regular_clocks(recording: Recording) -> Recording:
    """Recording on the clocks by which its samples were taken, with warnings about the corrections."""
    signals, warnings = dict(recording.signals), []
    for names in signals_by_stamps(recording):
        smoothest = next((name for name in ("position", "velocity", *EFFORT) if name in names), names[0])
        clock = regular_clock(signals[smoothest].time, signals[smoothest].values)
        if clock is None:
            continue
        warnings += [f"{', '.join(names)}: {fact}" for fact in clock.facts(signals[smoothest].time)]
        if clock.certain:
            signals |= {name: Signal(clock.time, signals[name].values) for name in names}
    earliest = min((float(signal.time[0]) for signal in signals.values() if len(signal)), default=0.0)
    if warnings and earliest < 0.0:  # the first message was late; files keep no time before the start
        signals = {name: Signal(signal.time - earliest, signal.values) for name, signal in signals.items()}
    return replace(recording, signals=signals).with_warnings(*warnings)


def signals_by_stamps(recording: Recording) -> list[list[str]]:
    """Names of the signals, grouped by common time stamps."""
    sharing: dict[bytes, list[str]] = {}
    for name, signal in recording.signals.items():
        sharing.setdefault(signal.time.tobytes(), []).append(name)
    return list(sharing.values())


def regular_clock(stamps: np.ndarray, values: np.ndarray) -> Clock | None:
    """Regular clock of samples whose stamps (t,) [s] are not their times; None if the stamps may be true.

    `values` (t, n) are smooth, preferably positions; NaN if unknown.
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
    if not arrivals:  # if the clock was only set, the stamps between the steps are true
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
    """Times on the line through the earliest stamps of each stretch, and whether these lie on a line."""
    count = max(len(stamps) // width, 2)
    slope = np.polyfit(number, stamps, 1)[0]
    for _ in range(2):  # which stamp is the earliest depends on the slope
        stretches = np.array_split(stamps - slope * number, count)
        starts = np.cumsum([0, *map(len, stretches[:-1])])
        places = starts + [np.argmin(stretch) for stretch in stretches]
        slope, start = np.polyfit(number[places], stamps[places], 1)
    off = stamps[places] - slope * number[places] - start
    return slope * number + start, bool(np.std(off) < STRAIGHT * slope)


def _real_share(late: np.ndarray, number: np.ndarray, values: np.ndarray) -> tuple[float, float, float]:
    """Share of the stamps' jitter that is real.

    On the clock by which it was taken, a position lies on a cubic through its neighbors. On the regular clock
    its residual is the motion during the jitter if the jitter is real, and zero if it is not.
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
    residual = off - share * moved
    return share, float(np.sqrt(residual @ residual / len(residual) / power)), float(often)


def _cubic(number: np.ndarray) -> np.ndarray:
    """Weights of the two neighbors on each side in the cubic through them, shape (t - 4, 4)."""
    inner = number[2:-2]
    nodes = np.stack([number[:-4], number[1:-3], number[3:-1], number[4:]], axis=1) - inner[:, None]
    weights = np.ones_like(nodes)
    for node in range(4):
        for other in set(range(4)) - {node}:
            weights[:, node] *= nodes[:, other] / (nodes[:, other] - nodes[:, node])
    return weights


def _misfit(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Residual of each inner value from the cubic through its neighbors, shape (t - 4, n)."""
    neighbors = np.stack([values[:-4], values[1:-3], values[3:-1], values[4:]], axis=1)
    return np.asarray(values[2:-2] - np.einsum("tk,tkn->tn", weights, neighbors))


def _spread(values: np.ndarray) -> np.ndarray:
    """Robust standard deviation of each column, at least the resolution of an encoder, shape (n,)."""
    return np.maximum(1.4826 * np.median(np.abs(values), axis=0), RESOLVED)


def _kind(stamps: np.ndarray, period: float) -> str:
    """Description of stamps (t,) [s] that are times of arrival."""
    steps = np.diff(stamps)
    for digit in DIGITS:
        if np.all(np.abs(steps / digit - np.round(steps / digit)) < 1e-3):
            return f"are rounded to {1e3 * digit:g} ms and wrong by that"
    short = steps < 0.25 * period
    if np.mean(short) > 0.3:
        return f"are times of arrival, in bursts of about {1.0 / (1.0 - np.mean(short)):.2g}, late"
    return "are times of arrival, late by varying delays"
