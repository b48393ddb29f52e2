"""Pictures of a diagnosis: profiles, spectra, bars over noise, a map of where and when."""

from collections.abc import Sequence
from html import escape

import numpy as np

from ...svg import Panel, legend, picture, text
from ...svg_scale import Span
from ..finding import Improvement
from ..forward import Forward
from ..trace import Trace
from .profiles import Axis, Profile, orders, profile, spectrum
from .told import Simulated

DOTS = 500
"""Dots in a profile; more hide one another."""
STRETCH = 20.0
"""Time that is drawn of a run [s]."""
CELLS = 72
"""Columns of a map: of half a minute, each is the time of a swing."""
PALE, FULL = 1.3, 4.0
"""Residual over noise from which a cell of the map has a colour, and at which it has its full colour: the
mean of so few rows is up to a third above noise by chance."""
KEYS = [("before", "before"), ("after", "after")]


def profile_plot(traces: Sequence[Trace], joint: int, axis: Axis, noise: float) -> str:
    """Residual of a joint against something, before and after: dots, and means of bins."""
    before, after = (profile(traces, joint, axis, which) for which in ("before", "after"))
    if not len(before.dots):
        return ""
    across = Span.around(before.dots[:, 0], margin=0.02)
    heights = [np.percentile(one.dots[:, 1], [1, 99]) for one in (before, after)]
    panel = Panel(across, Span.around(*heights, before.mean, np.array([noise]), zero=True), 64, 24, 400, 190)
    ends, limit = np.array([across.low, across.high]), np.full(2, noise)
    what = "residual against the motion [N m]" if axis.braking else "residual [N m]"
    content = (
        legend(64, 14, [*KEYS, ("bandkey", "noise")])
        + panel.axes(axis.label, what)
        + panel.band(ends, -limit, limit, "band")
        + _dots(panel, before, "cloud")
        + _dots(panel, after, "cloudafter")
        + panel.line(before.x, before.mean, "before")
        + panel.line(after.x, after.mean, "after")
    )
    return picture(472, 246, f"residual over {axis.label}", content)


def _dots(panel: Panel, one: Profile, style: str) -> str:
    chosen = np.unique(np.linspace(0, len(one.dots) - 1, min(DOTS, len(one.dots))).astype(int))
    return panel.dots(one.dots[chosen, 0], one.dots[chosen, 1], style)


def time_plot(trace: Trace, joint: int, noise: float) -> str:
    """Residual of a run over time, before and after, where most of it lies."""
    shown = _telling(trace, joint)
    time, slides = trace.time[shown], trace.weight[shown, joint] > 0
    before, after = (np.where(slides, rows[shown, joint], np.nan) for rows in (trace.before, trace.after))
    across = Span.around(time, margin=0.0)
    panel = Panel(across, Span.around(before, after, zero=True), 64, 24, 400, 190)
    ends, limit = np.array([across.low, across.high]), np.full(2, noise)
    content = (
        legend(64, 14, [*KEYS, ("bandkey", "noise")])
        + panel.axes("time [s]", "residual [N m]")
        + panel.band(ends, -limit, limit, "band")
        + panel.line(time, np.nan_to_num(before), "before thin")
        + panel.line(time, np.nan_to_num(after), "after thin")
    )
    return picture(472, 246, f"{trace.name}: residual over time", content)


def _telling(trace: Trace, joint: int) -> slice:
    """The whole run, or the stretch of it in which most of the residual lies."""
    length = int(np.searchsorted(trace.time, trace.time[0] + STRETCH, side="right"))
    if length >= len(trace.time):
        return slice(0, len(trace.time))
    squares = trace.before[:, joint] ** 2 * trace.weight[:, joint]
    total = np.cumsum(np.concatenate([[0.0], squares]))
    start = int(np.argmax(total[length:] - total[:-length]))
    return slice(start, start + length)


def spectrum_plot(trace: Trace, joint: int) -> str:
    """Amplitude of a residual over frequency, before and after."""
    return _spectra([spectrum(trace, joint, which) for which in ("before", "after")], "frequency [Hz]")


def orders_plot(traces: Sequence[Trace], joint: int, motor: bool) -> str:
    """Amplitude of a residual over waves per turn of the joint or its motor, before and after."""
    lines = [orders(traces, joint, which, motor) for which in ("before", "after")]
    return _spectra(lines, f"waves per turn of the {'motor' if motor else 'joint'}")


def _spectra(lines: Sequence[tuple[np.ndarray, np.ndarray]], label: str) -> str:
    across = Span.around(lines[0][0], margin=0.0)
    top = max(float(np.max(amplitude)) for _, amplitude in lines)
    panel = Panel(across, Span(0.0, 1.06 * top or 1.0), 64, 24, 400, 190)
    content = legend(64, 14, KEYS) + panel.axes(label, "residual, amplitude [N m]")
    for (x, amplitude), (style, _) in zip(lines, KEYS, strict=True):
        content += panel.line(x, amplitude, style)
    return picture(472, 246, f"residual over {label}", content)


def bars(found: Improvement, names: Sequence[str]) -> str:
    """Held-out residual of every joint over its noise, before and after, on a scale of roots."""
    before, after = found.before / found.noise, found.after / found.noise
    return _bars(before, after, names, "residual over noise", 1.0)


def forward_bars(found: Simulated, noise: np.ndarray, names: Sequence[str]) -> str:
    """The same of simulated torque."""
    return _bars(found.before / noise, found.after / noise, names, "simulated less recorded, over noise", 1.0)


def _bars(before: np.ndarray, after: np.ndarray, names: Sequence[str], label: str, one: float) -> str:
    most = max(float(np.max(before)), float(np.max(after)), 2.0)
    left, width, step = 110.0, 350.0, 34.0
    height = step * len(names)
    scale = width / np.sqrt(most)
    parts = [legend(left, 44 + height, KEYS)]
    for place, (name, first, second) in enumerate(zip(names, before, after, strict=True)):
        top = 26 + place * step
        parts.append(text(left - 8, top + 17, name, "name end"))
        for row, (value, style) in enumerate(((first, "barbefore"), (second, "barafter"))):
            length, y = scale * float(np.sqrt(max(value, 0.0))), top + 2 + 12 * row
            parts.append(f'<rect class="{style}" x="{left:g}" y="{y:.1f}" width="{length:.1f}" height="10"/>')
            parts.append(text(left + length + 5, y + 9, f"{value:.3g}", "tick"))
    x = left + scale * np.sqrt(one)
    parts.append(f'<line class="one" x1="{x:.1f}" x2="{x:.1f}" y1="20" y2="{26 + height:.1f}"/>')
    parts.append(text(x, 15, "noise", "tick middle"))
    return picture(520, 50 + height, label, "".join(parts))


def where_and_when(trace: Trace, noise: np.ndarray, names: Sequence[str], residuals: str) -> str:
    """A map of one run: joints downwards, time across, the darker the more is left over the noise."""
    left, width, step = 110.0, 350.0, 20.0
    edges = np.linspace(0, len(trace.time), CELLS + 1).astype(int)
    parts = []
    for joint, name in enumerate(names):
        top = 8 + joint * step
        parts.append(text(left - 8, top + 13, name, "name end"))
        squares = getattr(trace, residuals)[:, joint] ** 2 * trace.weight[:, joint]
        for cell in range(CELLS):
            rows = slice(edges[cell], edges[cell + 1])
            sliding = float(np.sum(trace.weight[rows, joint]))
            share = np.sqrt(np.sum(squares[rows]) / sliding) / noise[joint] if sliding else 1.0
            depth = np.clip((share - PALE) / (FULL - PALE), 0.0, 1.0)
            if depth > 0.0:
                x = left + width * cell / CELLS
                parts.append(
                    f'<rect class="heat" x="{x:.1f}" y="{top:g}" width="{width / CELLS + 0.2:.1f}" '
                    f'height="{step - 2:g}" fill-opacity="{depth:.2f}"/>'
                )
    bottom = 8 + step * len(names)
    frame = f'<rect class="frame" x="{left:g}" y="8" width="{width:g}" height="{bottom - 10:g}"/>'
    first, last = f"{trace.time[0]:.0f} s", f"{trace.time[-1]:.0f} s"
    ends = text(left, bottom + 12, first, "tick") + text(left + width, bottom + 12, last, "tick end")
    title = f"{escape(trace.name)}, {residuals}: residual over noise"
    return picture(472, bottom + 18, title, frame + "".join(parts) + ends)


def forward_plot(found: Forward, joint: int) -> str:
    """Torque of a joint in simulation before and after, beside what was recorded."""
    length = int(np.searchsorted(found.time, found.time[0] + STRETCH, side="right"))
    shown = slice(0, min(length, len(found.time)))
    time = found.time[shown]
    left = [(found.measured - one)[shown, joint] for one in (found.torque_before, found.torque_after)]
    weight = found.weight[shown, joint]
    panel = Panel(
        Span.around(time, margin=0.0),
        Span.around(*(one * weight for one in left), zero=True),
        64,
        24,
        400,
        190,
    )
    content = legend(64, 14, KEYS) + panel.axes("time [s]", "recorded less simulated [N m]")
    for one, (style, _) in zip(left, KEYS, strict=True):
        content += panel.line(time, one * weight, f"{style} thin")
    return picture(472, 246, f"{found.run}: recorded less simulated torque", content)
