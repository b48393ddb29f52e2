"""A plan as one HTML page with plots of each joint's motion and limits.

The page is self-contained: no scripts, no network, light and dark, printable.
"""

from collections.abc import Sequence

import numpy as np

from exidyn.identification.document.document import Figure, Grid, Paragraph, Section
from exidyn.identification.document.html import html
from exidyn.identification.pages.svg import COLUMNS, Panel, Span, legend, picture, text
from exidyn.identification.text_table import digits

from ..trajectory import unit_of
from .plan import Plan
from .plan_check import Curve, Use, limit_use, percent
from .plan_space import Space, space_figures
from .plan_summary import plan_document

LEFT, WIDTH, RIGHT = 64.0, 512.0, 56.0
"""Width of the labels, of a panel, and of its percentage [px]."""
HEIGHT, GAP = 84.0, 13.0
"""Height of a panel, and gap between two [px]."""
TOP, BOTTOM = 22.0, 32.0
"""Height of the legend above and of the time axis below [px]."""
PLANNED = "planned"
STYLES = ("moved", "loaded")
"""Styles of the lines of the first and second run."""
STYLE = """
svg .limit { stroke: var(--bad); stroke-width: 1.3px; stroke-dasharray: 6 4; stroke-linecap: butt; }
svg .forbidden { fill: var(--bad); fill-opacity: 0.11; stroke: none; }
svg .moved { stroke: var(--predicted); stroke-width: 1.4px; }
svg .loaded { stroke: var(--measured); stroke-width: 1.4px; }
svg .base { stroke: var(--ink); stroke-width: 7px; }
svg .beyond { stroke: var(--bad); stroke-width: 5px; }
svg .inside { fill: var(--ink); } svg .over { fill: var(--bad); font-weight: 600; }
@media print { svg .beyond { stroke-width: 3px; } .two figure svg { height: auto; } }
"""
"""Styles in addition to a report's style sheet."""


def plan_curves(plan: Plan, torque: Curve | None = None) -> list[Curve]:
    """Position, velocity, acceleration, jerk at every sampling period, and torque if it is known."""
    states = plan.trajectory.every(plan.tick)
    curves = [Curve(states.time, ((PLANNED, getattr(states, use.name)),), use) for use in limit_use(plan)]
    return curves if torque is None else [*curves, torque]


def joint_plot(plan: Plan, joint: int, curves: list[Curve], columns: int = COLUMNS) -> str:
    """Plot of a joint's quantities, one below the other, from position to jerk or torque."""
    keys = [("moved", PLANNED), ("limit", "limit")]
    keys += [("loaded", f"with payload {name}") for curve in curves for name, _ in curve.runs[1:]]
    if any(curve.use.violated[joint] for curve in curves):
        keys.append(("beyond", "beyond the limit"))
    content = legend(LEFT, 14, keys)
    for place, curve in enumerate(curves):
        top, last = TOP + place * (HEIGHT + GAP), place == len(curves) - 1
        content += _panel(curve, joint, plan.units[joint], top, last, columns)
    height = TOP + len(curves) * (HEIGHT + GAP) - GAP + BOTTOM
    names = ", ".join(curve.use.name for curve in curves)
    return picture(LEFT + WIDTH + RIGHT, height, f"{plan.joints[joint]}: {names} over time", content)


def _panel(curve: Curve, joint: int, unit: str, top: float, last: bool, columns: int) -> str:
    use, values = curve.use, [run[:, joint] for _, run in curve.runs]
    limits = np.array([use.lower[joint], use.upper[joint]])
    spread = Span.around(*values, limits, use.reached.lower[joint], use.reached.upper[joint])
    panel = Panel(Span.around(curve.time, margin=0.0), spread, LEFT, top, WIDTH, HEIGHT)
    lines = [panel.line(curve.time, v, style, columns) for v, style in zip(values, STYLES, strict=False)]
    return (
        panel.axes("time [s]" if last else "", _label(use.name, unit), x_ticks=last)
        + "".join(_limit(panel, limit, side) for limit, side in zip(limits, (-1, 1), strict=True))
        + "".join(lines)
        + panel.dots(*_beyond(curve, joint, columns), "beyond")
        + _used(use, joint, top)
    )


def _beyond(curve: Curve, joint: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Times and values beyond the limits: some samples, and the extremes, which may lie between them."""
    times, values = [], []
    for _, run in curve.runs:
        ticks = np.flatnonzero(curve.use.beyond(run[:, joint], joint))
        shown = ticks[np.linspace(0, len(ticks) - 1, min(columns, len(ticks))).astype(int)]
        times.append(curve.time[shown])
        values.append(run[shown, joint])
    reached = curve.use.reached
    ends = np.array([reached.lower[joint], reached.upper[joint]])
    worst = curve.use.beyond(ends, joint)
    times.append(np.array([reached.lower_time[joint], reached.upper_time[joint]])[worst])
    return np.concatenate(times), np.concatenate([*values, ends[worst]])


def _limit(panel: Panel, limit: float, side: int) -> str:
    """A limit as a line with the range beyond it shaded; empty if there is no limit."""
    if not np.isfinite(limit):
        return ""
    edge = panel.y.high if side > 0 else panel.y.low
    line = panel.line(np.array(panel.x), np.full(2, limit), "limit")
    return panel.level(limit, edge, "forbidden") + line


def _label(name: str, unit: str) -> str:
    short = {"acceleration": "accel."}.get(name, name)
    return f"{short} [{unit_of(name, unit).replace('^2', '²').replace('^3', '³')}]"


def _used(use: Use, joint: int, top: float) -> str:
    """The used share of the limit, beside the panel."""
    share, x, middle = use.share[joint], LEFT + WIDTH + 6, top + HEIGHT / 2
    if not np.isfinite(share):
        return text(x, middle + 4, "no limit", "tick")
    style = "over" if use.violated[joint] else "inside"
    used = text(x, middle - 2, f"{percent(share, '')} %", style)
    return used + text(x, middle + 11, "of limit", "tick")


SPACE = (
    "Path of the flange in the base frame, with the base at 0, 0. Obstacles are shaded; dashed lines are "
    "their edges, and walls seen edgewise."
)


def plan_page(
    plan: Plan,
    beyond: Sequence[str] = (),
    torque: Curve | None = None,
    space: Space | None = None,
    nearest: str = "",
) -> str:
    """HTML of the page; `nearest` has the nearest approaches in words, if collisions were checked."""
    curves = plan_curves(plan, torque)
    uses = [curve.use for curve in curves]
    figures = [
        Figure(name, _remark(plan, uses, joint), joint_plot(plan, joint, curves))
        for joint, name in enumerate(plan.joints)
    ]
    legend = (
        "Commands at every sampling period. Dashed: the robot's limits without margins; shaded: beyond them. "
        "Percentages are the largest value over the limit, also between samples"
        + ("; torque is that of the nominal model." if torque else ".")
    )
    document = plan_document(plan, uses, beyond, _remarks(plan, torque, nearest))
    sections = [*document.sections]
    if space is not None:
        views = Grid(space_figures(space), "two alike")
        sections.append(Section("space", "Space", [Paragraph(SPACE), views]))
    sections.append(Section("motion", "Motion", [Paragraph(legend), Grid(figures, "two alike")]))
    return html(document._replace(sections=sections), style=STYLE)


def _remarks(plan: Plan, torque: Curve | None, nearest: str) -> list[str]:
    """The nearest approach, and checks that this page does not include."""
    sentences = [f"Nearest: {nearest}."] if nearest else []
    unchecked = [] if nearest else ["collisions"]
    if torque is None:
        unchecked.append("torque, which needs the robot")
    elif plan.payload_pair and len(torque.runs) == 1:
        unchecked.append("torque of the loaded run, since the robot file names no payload")
    return sentences + ([f"Not checked here: {'; '.join(unchecked)}."] if unchecked else [])


def _remark(plan: Plan, uses: Sequence[Use], joint: int) -> str:
    """The largest velocity and torque in words."""
    chosen = [use for use in uses if use.name in ("velocity", "torque")]
    return "; ".join(
        f"{use.name} up to {digits(max(-use.reached.lower[joint], use.reached.upper[joint]), 3)} "
        f"{unit_of(use.name, plan.units[joint])}"
        for use in chosen
    )
