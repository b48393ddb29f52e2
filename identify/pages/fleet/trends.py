"""Values of one arm over its runs, as small plots, the temperature with them."""

import numpy as np
from markupsafe import Markup

from ...fleet.drift import Found
from ...fleet.report import KindReport, date_words, subject, temperature_of
from ..report_html import figure, grid
from ..svg import Panel, picture
from ..svg_scale import Span

WIDTH, HEIGHT, WARMTH = 560.0, 190.0, 60.0
"""Of a plot, and of the temperature's part of it [pixels]."""
WEEK = 7.0
TWO = 1.96
"""Deviations within which a value lies with 95 %."""


def trends(report: KindReport, arm: str) -> Markup:
    """A plot for each value that changed; where none did, for dry friction of every joint."""
    own, scattering = report.drifts[arm], report.scattering
    changed = {report.learned.frame.causes[one.cause].parameter: one for one in own.found}
    labels = [(one.effect, one.joint) for one in scattering]
    found = {
        labels.index((cause.effect, cause.joint)): one
        for one in own.found
        if (cause := report.learned.frame.causes[one.cause]) and (cause.effect, cause.joint) in labels
    }
    usual = [k for k, one in enumerate(scattering) if one.effect == "coulomb_friction"]
    shown = sorted(found) if changed and found else usual
    return grid(*(_trend(report, arm, k, found.get(k)) for k in shown))


def _trend(report: KindReport, arm: str, place: int, found: Found | None) -> Markup:
    runs, cause = report.learned.arms[arm], report.scattering[place]
    values, stds = (one[:, place] for one in report.values(arm))
    weeks, warm = (runs.days - runs.days[0]) / WEEK, temperature_of(runs)
    known = bool(np.all(np.isfinite(warm)))
    low, high = values - TWO * stds, values + TWO * stds
    across, height = Span.around(weeks), HEIGHT - (WARMTH if known else 0.0)
    upper = Panel(across, Span.around(low, high), 62.0, 8.0, WIDTH - 70.0, height - 16.0)
    unit = cause.unit or "ln(gain / nominal)"
    first = f"weeks since {date_words(runs.days[0])}"
    parts = [upper.axes("" if known else first, f"[{unit}]", x_ticks=not known)]
    if found is not None:
        begin, end = ((day - runs.days[0]) / WEEK for day in found.interval)
        edge = np.array([begin, end])
        ends = np.full(2, upper.y.low), np.full(2, upper.y.high)
        parts.append(upper.band(edge, *ends, "moment"))
    parts += [upper.band(weeks, low, high, "band"), upper.dots(weeks, values, "runs")]
    if known:
        lower = Panel(across, Span.around(warm), 62.0, height, WIDTH - 70.0, WARMTH - 8.0)
        parts += [lower.axes(first, "[degC]"), lower.line(weeks, warm, "residual")]
    words = subject(cause, report.learned.frame.kind.model.robot.joints)
    remark = "at the reference temperature" if cause.thermal and known else ""
    return figure(words, remark, picture(WIDTH, HEIGHT + 34.0, f"{arm}: {words}", "".join(parts)))
