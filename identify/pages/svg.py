"""Plots as static SVG: panels with axes, bands, dots, and lines reduced to screen resolution."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from markupsafe import Markup

COLUMNS = 320
"""Number of stretches of a line whose extremes are drawn: one every two pixels of a panel."""
LARGEST = 1.5
"""Largest magnification of a plot in a wide column, so that its letters do not exceed headings."""
GRAIN = 10
"""Units of path coordinates per pixel; integers keep files small."""


LEFT, TOP, RIGHT, BOTTOM = 64.0, 24.0, 8.0, 32.0
"""Margins around a single panel: for labels of its axes, and for a legend above it [pixels]."""


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
        """Range of all finite values with a margin; symmetric about zero if `zero` is set."""
        finite = np.concatenate([np.ravel(v) for v in values]) if values else np.zeros(1)
        finite = finite[np.isfinite(finite)]
        low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)
        if zero:
            high = max(abs(low), abs(high))
            low = -high
        spare = margin * (high - low) if high > low else 0.5 * abs(high) or 1.0
        return cls(low - spare, high + spare)


def ticks(span: Span, count: int) -> np.ndarray:
    """About `count` multiples of 1, 2 or 5 times a power of ten within the range."""
    power = 10.0 ** np.floor(np.log10(span.size / count))
    steps = [factor * power for factor in (0.5, 1, 2, 5, 10)]
    choices = [step * np.arange(np.ceil(span.low / step), np.floor(span.high / step) + 1) for step in steps]
    return min(choices, key=lambda values: abs(len(values) - count))


def stretch(time: np.ndarray, squares: np.ndarray, longest: float) -> slice:
    """All samples (r,), or the stretch of `longest` [s] in which the sum of squares (r,) is largest."""
    length = int(np.searchsorted(time, time[0] + longest, side="right"))
    if length >= len(time):
        return slice(0, len(time))
    total = np.cumsum(np.concatenate([[0.0], squares]))
    start = int(np.argmax(total[length:] - total[:-length]))
    return slice(start, start + length)


def label(value: float, span: Span) -> str:
    """Text of a tick, with at most six digits and zero instead of rounding errors."""
    if abs(value) < 1e-9 * span.size:
        return "0"
    return f"{value:.6g}".replace("-", "\N{MINUS SIGN}")


@dataclass(frozen=True)
class Panel:
    """A rectangle of a plot with its own scales."""

    x: Span  # horizontal range of the data
    y: Span  # vertical range of the data
    left: float  # distance from the left edge of the plot [pixels]
    top: float  # distance from the upper edge of the plot [pixels]
    width: float  # width [pixels]
    height: float  # height [pixels]

    @classmethod
    def single(cls, x: Span, y: Span, width: float = 400.0, top: float = TOP) -> "Panel":
        """The panel of a plot that has no other, see `plot`."""
        return cls(x, y, LEFT, top, width, 190.0)

    def plot(
        self, title: str, labels: tuple[str, str], keys: Sequence[tuple[str, str]], *marks: str
    ) -> Markup:
        """The plot of a single panel: a legend of (style, words), labels of x and y, and marks over them."""
        content = (legend(LEFT, 14, keys) if keys else "") + self.axes(*labels) + "".join(marks)
        return picture(self.left + self.width + RIGHT, self.top + self.height + BOTTOM, title, content)

    def level(self, low: float, high: float, style: str) -> str:
        """A band between two values over the width of the panel."""
        return self.band(np.array(self.x), np.full(2, low), np.full(2, high), style)

    def stripe(self, start: float, end: float, style: str) -> str:
        """A band between two places over the height of the panel."""
        return self.band(np.array([start, end]), np.full(2, self.y.low), np.full(2, self.y.high), style)

    def pixels(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Data in tenths of pixels, shape (k, 2); points above or below the panel move to its edge."""
        across = self.left + self.width * (np.asarray(x, float) - self.x.low) / self.x.size
        share = np.clip((np.asarray(y, float) - self.y.low) / self.y.size, 0.0, 1.0)
        down = self.top + self.height * (1.0 - share)
        return np.rint(GRAIN * np.column_stack([across, down])).astype(int)

    @property
    def frame(self) -> str:
        """Background and border of the panel."""
        size = f'width="{self.width:.1f}" height="{self.height:.1f}"'
        return f'<rect class="frame" x="{self.left:.1f}" y="{self.top:.1f}" {size}/>'

    def axes(self, x_label: str, y_label: str, x_ticks: bool = True) -> str:
        """Frame, grid, tick labels and axis labels with their units."""
        bottom, right = self.top + self.height, self.left + self.width
        parts = [self.frame]
        for value in ticks(self.x, 6):
            place = self.left + self.width * (value - self.x.low) / self.x.size
            parts.append(_line("grid", place, self.top, place, bottom))
            if x_ticks:
                parts.append(text(place, bottom + 13, label(value, self.x), "tick middle"))
        for value in ticks(self.y, max(4, int(self.height / 26))):
            place = bottom - self.height * (value - self.y.low) / self.y.size
            parts.append(_line("grid", self.left, place, right, place))
            parts.append(text(self.left - 5, place + 4, label(value, self.y), "tick end"))
        if x_label:
            parts.append(text(right, bottom + 27, x_label, "axis end"))
        turned = f'transform="translate(12 {self.top + self.height / 2:.1f}) rotate(-90)"'
        parts.append(f'<text class="axis middle" {turned}>{escape(y_label)}</text>')
        return "".join(parts)

    def line(self, x: np.ndarray, y: np.ndarray, style: str, columns: int = COLUMNS) -> str:
        """A line, reduced so that all extremes remain, with gaps where y is not finite."""
        known = np.isfinite(y)
        if known.all():
            drawn = envelope(y, columns)
            return path(self.pixels(x[drawn], y[drawn]), style)
        ends = np.flatnonzero(np.diff(known, prepend=False, append=False)).reshape(-1, 2)
        share = columns / len(y)
        return "".join(self.line(x[a:b], y[a:b], style, max(int(share * (b - a)), 1)) for a, b in ends)

    def band(self, x: np.ndarray, low: np.ndarray, high: np.ndarray, style: str) -> str:
        """The area between two lines."""
        edge = np.concatenate([self.pixels(x, low), self.pixels(x, high)[::-1]])
        return path(edge, style, closed=True)

    def dots(self, x: np.ndarray, y: np.ndarray, style: str) -> str:
        """Separate dots: strokes of no length with round ends."""
        steps = "".join(f"M{a} {b}h0" for a, b in self.pixels(x, y))
        return _path(steps, style)


def envelope(y: np.ndarray, columns: int) -> np.ndarray:
    """Indices of the lowest and highest sample of each of `columns` stretches, in order."""
    if len(y) <= 2 * columns:
        return np.arange(len(y))
    edges = np.linspace(0, len(y), columns + 1).astype(int)
    pairs = [(a + int(np.argmin(y[a:b])), a + int(np.argmax(y[a:b]))) for a, b in pairwise(edges)]
    return np.unique([0, len(y) - 1, *(index for pair in pairs for index in pair)])


def path(points: np.ndarray, style: str, closed: bool = False) -> str:
    """A path through points (k, 2) in tenths of pixels, written as steps from one to the next."""
    if len(points) == 0:
        return ""
    steps = "".join(f"{a} {b} " if b >= 0 else f"{a}{b} " for a, b in np.diff(points, axis=0))
    first = f"M{points[0, 0]} {points[0, 1]}"
    return _path(f"{first}l{steps.strip()}{'z' if closed else ''}" if steps else f"{first}h0", style)


def text(x: float, y: float, words: str, style: str) -> str:
    """Words at a place in pixels."""
    return f'<text class="{style}" x="{x:.1f}" y="{y:.1f}">{escape(words)}</text>'


Keys = Sequence[tuple[str, str]]
"""Style and words of each entry of a legend."""


def legend(x: float, y: float, entries: Keys) -> str:
    """A row of (style, words), each with a sample of its line; in a grid `alike`, only the first shows it."""
    parts = []
    for style, words in entries:
        parts.append(path(np.rint(GRAIN * np.array([[x, y - 4], [x + 18, y - 4]])).astype(int), style))
        parts.append(text(x + 23, y, words, "key"))
        x += 38 + 6.1 * len(words)  # a letter of eleven pixels is about six wide
    return f'<g class="legend">{"".join(parts)}</g>'


def picture(width: float, height: float, title: str, content: str) -> Markup:
    """A plot that fills its column up to `LARGEST`; the title is for screen readers and tooltips."""
    shape = f'viewBox="0 0 {width:g} {height:g}" style="max-width: {LARGEST * width:g}px"'
    head = f'<svg {shape} role="img"><title>{escape(title)}</title>'
    return Markup(f"{head}{content}</svg>")


def _path(steps: str, style: str) -> str:
    return f'<path class="{style}" transform="scale({1 / GRAIN:g})" d="{steps}"/>'


def _line(style: str, x1: float, y1: float, x2: float, y2: float) -> str:
    return f'<line class="{style}" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'
