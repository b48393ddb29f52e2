"""Scales of a plot: ranges, round ticks and their labels; which stretch of a run is drawn."""

from typing import NamedTuple

import numpy as np


class Span(NamedTuple):
    """A range of data, never empty."""

    low: float
    high: float

    @property
    def size(self) -> float:
        """Length of the range."""
        return self.high - self.low

    @classmethod
    def around(cls, *values: np.ndarray, margin: float = 0.06, zero: bool = False) -> "Span":
        """Range of all finite values and a margin, symmetric about zero if asked."""
        every = np.concatenate([np.ravel(v) for v in values]) if values else np.zeros(1)
        every = every[np.isfinite(every)]
        low, high = (float(every.min()), float(every.max())) if len(every) else (0.0, 0.0)
        if zero:
            high = max(abs(low), abs(high))
            low = -high
        spare = margin * (high - low) if high > low else 0.5 * abs(high) or 1.0
        return cls(low - spare, high + spare)


def ticks(span: Span, count: int) -> np.ndarray:
    """Multiples of 1, 2 or 5 times a power of ten within the range, as near to `count` as can be."""
    power = 10.0 ** np.floor(np.log10(span.size / count))
    choices = [_multiples(span, factor * power) for factor in (0.5, 1, 2, 5, 10)]
    return min(choices, key=lambda values: abs(len(values) - count))


def _multiples(span: Span, step: float) -> np.ndarray:
    return step * np.arange(np.ceil(span.low / step), np.floor(span.high / step) + 1)


def stretch(time: np.ndarray, squares: np.ndarray, longest: float) -> slice:
    """All samples (r,), or the stretch of `longest` [s] in which the sum of squares (r,) is largest."""
    length = int(np.searchsorted(time, time[0] + longest, side="right"))
    if length >= len(time):
        return slice(0, len(time))
    total = np.cumsum(np.concatenate([[0.0], squares]))
    start = int(np.argmax(total[length:] - total[:-length]))
    return slice(start, start + length)


def label(value: float, span: Span) -> str:
    """A tick's value with no more digits than the range deserves."""
    if abs(value) < 1e-9 * span.size:
        return "0"
    return f"{value:.6g}".replace("-", "\N{MINUS SIGN}")
