"""Plots: lines keep their extremes, scales their ticks, and what is drawn is what was given."""

import re
from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.pages.fit_plots import informative_stretch, interval_bar, torque_plot
from exidyn.identification.pages.svg import Panel, Span, envelope, label, path, ticks

from ...parts.pages.report_pages import Page, known_fit, points_of


@pytest.fixture(scope="module")
def fit():
    return known_fit()


def test_a_line_passes_through_its_samples(fit):
    run = fit.validation[0]
    drawn = Page(torque_plot(run, fit.model.robot, 1, columns=len(run.time)))
    (steps,) = [
        attrs["d"] for tag, attrs in drawn.elements
        if tag == "path" and attrs["class"] == "predicted dashed" and len(attrs["d"]) > 40
    ]  # fmt: skip
    points = points_of(steps)
    assert len(points) == len(run.time)
    values = run.predicted[:, 1]
    slope, level = np.polyfit(points[:, 1], values, 1)
    assert slope < 0.0
    # a tenth of a pixel of some hundred that the panel is high
    assert np.abs(slope * points[:, 1] + level - values).max() < np.ptp(values) / 1000


def test_thinning_keeps_every_extreme():
    y = np.random.default_rng(0).normal(size=5000)
    kept = envelope(y, 100)
    assert len(kept) <= 202
    assert np.all(np.diff(kept) > 0)
    edges = np.linspace(0, len(y), 101).astype(int)
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        part = y[kept[(kept >= a) & (kept < b)]]
        assert (part.min(), part.max()) == (y[a:b].min(), y[a:b].max())


def test_long_run_shows_its_worst_minute(fit):
    run = fit.validation[0]
    count = 4 * len(run.time)
    time = np.arange(count) * (run.time[1] - run.time[0])
    assert time[-1] > 70.0
    measured = np.zeros((count, 2))
    measured[-50:-40, 1] = 5.0  # the residual of nothing predicted
    ones = np.ones((count, 2))
    long = replace(run, time=time, measured=measured, predicted=0 * ones, weight=ones)
    shown = informative_stretch(long, 1)
    assert time[shown][-1] - time[shown][0] == pytest.approx(60.0, abs=0.1)
    assert shown.start <= count - 50
    assert count - 40 <= shown.stop
    assert informative_stretch(run, 1) == slice(0, len(run.time))


def test_marks_stay_within_their_panel():
    panel = Panel(Span(0.0, 2.0), Span(-1.0, 1.0), 50, 10, 100, 40)
    found = panel.pixels(np.array([0.0, 2.0, 1.0]), np.array([-1.0, 1.0, 70.0]))
    np.testing.assert_array_equal(found, [[500, 500], [1500, 100], [1000, 100]])
    assert "<circle" in interval_bar(1.0, 0.1, 1.2, 0.2)
    assert "<circle" not in interval_bar(9.0, 0.1, 1.2, 0.2)
    assert interval_bar(1.0, 0.1, 0.0, np.inf) == "no nominal value"
    points = np.array([[10, 20], [15, 5], [15, 5], [-3, 40]])
    steps = re.search(r' d="(.*?)"', path(points, "residual"))[1]
    np.testing.assert_array_equal(points_of(steps), points)


@pytest.mark.parametrize(
    "span", [Span(-2300.0, 2700.0), Span(0.0131, 0.0144), Span(1e5, 3e6), Span(-1e-7, 2e-7)]
)
def test_ticks_are_round_and_few(span):
    found = ticks(span, 5)
    assert 3 <= len(found) <= 7
    slack = 1e-9 * span.size
    assert np.all((found >= span.low - slack) & (found <= span.high + slack))
    mantissa = np.diff(found)[0] / 10.0 ** np.floor(np.log10(np.diff(found)[0]) + 1e-9)
    assert min(abs(mantissa - m) for m in (1, 2, 5)) < 1e-6
    labels = [label(value, span) for value in found]
    assert len(set(labels)) == len(labels)


@pytest.mark.parametrize("values", [[], [3.0, 3.0], [0.0], [np.nan, np.inf]])
def test_ranges_are_never_empty(values):
    span = Span.around(np.array(values))
    assert np.isfinite(span).all()
    assert span.size > 0.0
