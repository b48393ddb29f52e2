"""The report: its numbers are the fit's, its pictures are finite, and it needs nothing else."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from exidyn.identify.base_parameters import base_parameters
from exidyn.identify.effects import Hysteresis, LoadDependentFriction, StribeckFriction
from exidyn.identify.fit import Fit
from exidyn.identify.friction_curve import friction_curve
from exidyn.identify.identify import identify
from exidyn.identify.report import write_report
from exidyn.identify.report_html import rounded
from exidyn.identify.report_plots import interval_bar, torque_plot, velocity_grid
from exidyn.identify.svg import Panel, envelope, path
from exidyn.identify.svg_scale import Span, label, ticks
from exidyn.identify.verdict import joint_verdicts, surprises, verdict

from .test_identify import BODY, record
from .two_joints import model


class Page(HTMLParser):
    """Elements of a page; fails where tags do not close in order."""

    def __init__(self, text):
        super().__init__()
        self.open, self.elements, self.rows, self.data, self.words = [], [], {}, [], ""
        self.section, self.value = "", None
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.elements.append((tag, attrs))
        if tag == "meta":
            return
        self.open.append(tag)
        if tag == "section":
            self.section = attrs["id"]
        if tag == "tr":
            self.rows.setdefault(self.section, []).append([])
        if tag == "td":
            self.rows[self.section][-1].append(("", []))
        if tag == "data":
            self.value = attrs["value"]

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, words):
        self.words += words
        if self.open and self.open[-1] == "data":
            self.data.append((float(self.value), words))
        if "td" in self.open and "svg" not in self.open:
            text, values = self.rows[self.section][-1][-1]
            more = [float(self.value)] if self.open[-1] == "data" else []
            self.rows[self.section][-1][-1] = (text + words, values + more)

    def row(self, section, first):
        """The row of a section that starts with this word."""
        found = [row for row in self.rows[section] if row and row[0][0] == first]
        assert len(found) == 1, (section, first)
        return found[0]


@pytest.fixture(scope="module")
def fit():
    return identify([record(0), record(1, payload=BODY)], validate=[record(5)])


def page_of(fit, tmp_path):
    write_report(fit, tmp_path / "report.html")
    return Page((tmp_path / "report.html").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def page(fit, tmp_path_factory):
    return page_of(fit, tmp_path_factory.mktemp("report"))


def bare(fit):
    """The fit as it comes back without samples."""
    return replace(fit, agreement=(), validation=())


def values_of(row, *columns):
    return [row[column][1][0] for column in columns]


def test_needs_nothing_from_elsewhere(page, fit, tmp_path):
    tags = {tag for tag, _ in page.elements}
    assert not tags & {"script", "link", "img", "iframe", "object", "base", "use", "image"}
    for _, attrs in page.elements:
        assert not {"src", "srcset", "data", "xlink:href", "onload"} & set(attrs)
        assert attrs.get("href", "#").startswith("#")
    write_report(fit, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert not re.search(r"https?:|//|url\(|@import|@font-face", text)
    assert len(text.encode()) < 2e6


def test_links_lead_to_sections(page):
    anchors = {attrs["id"] for tag, attrs in page.elements if tag == "section"}
    links = [attrs["href"][1:] for tag, attrs in page.elements if tag == "a"]
    assert len(links) == 8
    assert set(links) == anchors


def test_every_base_parameter_is_shown_as_it_is(page, fit):
    estimate, (believed, deviation) = fit.estimate, fit.believed
    for k, name in enumerate(fit.names):
        row = page.row("parameters", name)
        value, half, percent = values_of(row, 1, 3, 4)
        assert value == estimate.values[k]
        assert half == pytest.approx(1.96 * estimate.std[k], rel=1e-12)
        assert percent == pytest.approx(100 * estimate.std[k] / abs(value), rel=1e-12)
        assert row[2][0] == fit.base.units[k].replace("^2", "²")
        if np.isfinite(deviation[k]):
            assert values_of(row, 5, 6) == [believed[k], deviation[k]]
        else:
            assert row[5][1] == row[6][1] == []


def test_drive_gains_are_shown_as_they_are(page, fit):
    for k, joint in enumerate(fit.model.robot.joints):
        row = page.row("gains", joint)
        gain, half, belief = values_of(row, 1, 3, 5)
        assert gain == fit.estimate.gain[k]
        assert half == pytest.approx(1.96 * fit.estimate.gain_std[k], rel=1e-12)
        assert belief == fit.model.robot.drive_gain[k]


def test_agreement_is_shown_as_it_is(page, fit):
    (held_out,) = fit.validation
    for k, joint in enumerate(fit.model.robot.joints):
        numbers = values_of(page.row("verdict", joint), 2, 3, 4, 5, 6)
        shown = held_out.over_noise, held_out.residual_rms, held_out.noise, 100 * held_out.relative
        assert numbers == [values[k] for values in (*shown, held_out.r_squared)]
    for run in (*fit.agreement, held_out):
        cells = page.row("runs", run.run)[2:]
        assert [cell[1] for cell in cells] == [
            list(pair) for pair in zip(run.over_noise, 100 * run.relative, strict=True)
        ]


def test_dropped_and_condition_are_shown_as_they_are(fit, tmp_path):
    page = page_of(replace(fit, dropped={"Off9": -0.0234567, "XX9R": 1.5}), tmp_path)
    assert values_of(page.row("structure", "Off9"), 1) == [-0.0234567]
    assert values_of(page.row("structure", "XX9R"), 1) == [1.5]
    assert (fit.condition, rounded(fit.condition, 3)) in page.data
    for line in fit.base.expressions:
        assert line in page.words


def test_worst_pairs_are_correlated_as_said(page, fit):
    names = [*fit.names, *(f"gain of {joint}" for joint in fit.model.robot.joints)]
    covariance = fit.estimate.covariance
    std = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(std, std)
    rows = [row for row in page.rows["conditioning"] if row]
    for row in rows:
        a, b = (names.index(name) for name in row[0][0].split(" and "))
        assert row[1][1] == [pytest.approx(correlation[a, b], rel=1e-12)]
    worst = np.abs(np.triu(correlation, 1)).max()
    assert abs(rows[0][1][1][0]) == pytest.approx(worst, rel=1e-12)


def test_texts_are_roundings_of_their_values(page):
    assert len(page.data) > 100
    for value, text in page.data:
        shown = float(text.replace("\N{MINUS SIGN}", "-"))
        assert shown == pytest.approx(value, rel=0.051, abs=0)  # two digits at least


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (1529.83, 4, "1530"),
        (114.07, 2, "114"),
        (-0.021634, 3, "−0.0216"),
        (2.5e-7, 2, "2.5e−7"),
        (0.0, 3, "0"),
        (49683.4, 3, "49683"),
        (1.0, 3, "1.00"),
        (-3.2e8, 2, "−3.2e8"),
    ],
)
def test_rounding(value, digits, text):
    assert rounded(value, digits) == text


def points_of(steps):
    """Vertices of a path as our module writes it, shape (k, 2) in tenths of pixels."""
    start, rest = re.fullmatch(r"M(-?\d+ -?\d+)(?:l([\d \-]*)z?|h0)", steps).groups()
    numbers = [int(n) for n in re.findall(r"-?\d+", rest or "")]
    return np.cumsum([[int(n) for n in start.split()], *np.reshape(numbers, (-1, 2)).astype(int)], axis=0)


def test_pictures_are_finite_and_inside_their_frames(page):
    size, paths = (0.0, 0.0), 0
    for tag, attrs in page.elements:
        if tag == "svg":
            size = tuple(float(n) for n in attrs["viewbox"].split()[2:])
        for name in {"x", "y", "x1", "x2", "y1", "y2", "cx", "cy", "width", "height"} & set(attrs):
            if tag in ("rect", "line", "circle", "text"):
                assert 0.0 <= float(attrs[name]) <= max(size), (tag, attrs)
        if tag == "path" and "transform" in attrs:
            paths += 1
            numbers = points_of(attrs["d"]) if "h0M" not in attrs["d"] else dots_of(attrs["d"])
            assert numbers.min() >= 0
            assert np.all(numbers <= np.multiply(10, size))
    joints, runs = 2, 3
    assert paths >= joints * runs * 3 + joints * 3


def dots_of(steps):
    return np.array([[int(n) for n in pair] for pair in re.findall(r"M(\d+) (\d+)h0", steps)])


def test_a_line_passes_through_its_samples(fit):
    run = fit.validation[0]
    drawn = Page(torque_plot(run, fit.model.robot, 1, columns=len(run.time)))
    (steps,) = [
        attrs["d"] for tag, attrs in drawn.elements
        if tag == "path" and attrs["class"] == "predicted" and len(attrs["d"]) > 40
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


def test_path_steps_lead_through_the_points():
    points = np.array([[10, 20], [15, 5], [15, 5], [-3, 40]])
    steps = re.search(r' d="(.*?)"', path(points, "residual"))[1]
    np.testing.assert_array_equal(points_of(steps), points)


def test_panel_maps_its_corners_and_holds_what_leaves_it():
    panel = Panel(Span(0.0, 2.0), Span(-1.0, 1.0), 50, 10, 100, 40)
    found = panel.pixels(np.array([0.0, 2.0, 1.0]), np.array([-1.0, 1.0, 70.0]))
    np.testing.assert_array_equal(found, [[500, 500], [1500, 100], [1000, 100]])


@pytest.mark.parametrize(
    "span", [Span(-2300.0, 2700.0), Span(0.0131, 0.0144), Span(1e5, 3e6), Span(-1e-7, 2e-7)]
)
def test_ticks_are_round_and_few(span):
    found = ticks(span, 5)
    assert 2 <= len(found) <= 6
    assert np.all((found >= span.low) & (found <= span.high))
    mantissa = np.diff(found)[0] / 10.0 ** np.floor(np.log10(np.diff(found)[0]) + 1e-9)
    assert min(abs(mantissa - m) for m in (1, 2, 5)) < 1e-6
    labels = [label(value, span) for value in found]
    assert len(set(labels)) == len(labels)


@pytest.mark.parametrize("values", [[], [3.0, 3.0], [0.0], [np.nan, np.inf]])
def test_ranges_are_never_empty(values):
    span = Span.around(np.array(values))
    assert np.isfinite(span).all()
    assert span.size > 0.0


def test_interval_far_from_its_belief_becomes_an_arrow():
    assert "<circle" in interval_bar(1.0, 0.1, 1.2, 0.2)
    assert "<circle" not in interval_bar(9.0, 0.1, 1.2, 0.2)
    assert interval_bar(1.0, 0.1, 0.0, np.inf) == "no belief"


def test_fit_without_samples_says_so(fit, tmp_path):
    page = page_of(bare(fit), tmp_path)
    assert "loaded without its samples" in page.words
    assert "torque and residual over time" not in page.words
    assert "friction over velocity" in page.words
    assert page.row("parameters", fit.names[0])[1][1] == [fit.estimate.values[0]]


def test_names_cannot_break_the_page(fit, tmp_path):
    odd = replace(fit, validation=(replace(fit.validation[0], run="<b>&"),), doubts=("1 < 2 & <i>3",))
    page = page_of(odd, tmp_path)
    assert "<b>&" in page.words
    assert "1 < 2 & <i>3" in page.words
    assert not {"b", "i"} & {tag for tag, _ in page.elements}


def with_noise(fit: Fit, *share: float):
    """The fit with the residual of its validation at so many noises, one number a joint."""
    run = fit.validation[0]
    return replace(fit, validation=(replace(run, noise=run.residual_rms / np.array(share)),))


def test_verdict_names_the_joint_that_is_not_explained(fit):
    first = verdict(with_noise(fit, 1.0, 4.2))[0]
    assert "1 of 2 joints" in first
    assert "elbow (4.2 x noise: physics is missing)" in first
    assert [v.words for v in joint_verdicts(with_noise(fit, 1.4, 1.29))] == [
        "a little is missing",
        "explained to its noise",
    ]


def test_verdict_takes_the_worst_run_of_each_joint(fit):
    worse = with_noise(fit, 3.0, 0.5).validation[0]
    better = replace(with_noise(fit, 0.5, 2.0).validation[0], run="other")
    found = joint_verdicts(replace(fit, validation=(worse, better)))
    assert [(v.run, round(v.over_noise, 6)) for v in found] == [(worse.run, 3.0), ("other", 2.0)]


def test_verdict_warns_without_a_run_held_out(fit):
    assert "flatters" in verdict(replace(fit, validation=()))[0]
    assert "flatters" not in verdict(fit)[0]


def test_verdict_counts_the_gains_and_repeats_doubts(fit):
    lines = verdict(replace(fit, doubts=("the clock jumps",)))
    percent = 100 * fit.estimate.gain_std / np.abs(fit.estimate.gain)
    assert f"{percent.min():.2g} to {percent.max():.2g} %" in lines[1]
    assert lines[-1] == "the clock jumps"


def test_surprise_is_a_value_far_from_its_belief(fit):
    deviation = np.full(len(fit.names), np.inf)
    deviation[2] = 1.0
    believed = np.array(fit.estimate.values)
    believed[2] += 3.5 * np.hypot(1.0, fit.estimate.std[2])
    assert surprises(replace(fit, believed=(believed, deviation))) == [fit.names[2]]


def test_friction_curve_is_viscous_and_dry_friction(fit):
    velocity = velocity_grid(2.0)
    names = list(fit.names)
    for joint in range(2):
        viscous, dry = names.index(f"Fv{joint + 1}"), names.index(f"Fc{joint + 1}")
        sign = np.tanh(velocity / 0.003)
        torque, std = friction_curve(fit, joint, velocity)
        values = fit.estimate.values
        np.testing.assert_allclose(torque, values[viscous] * velocity + values[dry] * sign, rtol=1e-9)
        covariance = fit.estimate.covariance[np.ix_([viscous, dry], [viscous, dry])]
        rows = np.stack([velocity, sign], axis=1)
        np.testing.assert_allclose(std**2, np.einsum("tp,pq,tq->t", rows, covariance, rows), rtol=1e-9)


def curve_with(fit, effect, **values):
    """Curve of joint 0 where one effect is added to the model and everything else is zero."""
    enlarged = model(effect)
    base = base_parameters(enlarged)
    plain = [enlarged.names[column] for column in base.kept]
    estimate = replace(
        fit.estimate,
        values=np.array([values.get(name, 0.0) for name in plain]),
        covariance=np.zeros((len(plain) + 2, len(plain) + 2)),
    )
    velocity = np.array([-1.0, -0.1, 0.1, 1.0])
    return velocity, friction_curve(replace(fit, model=enlarged, base=base, estimate=estimate), 0, velocity)[
        0
    ]


def test_friction_curve_knows_effects_by_what_they_do(fit):
    velocity, torque = curve_with(fit, StribeckFriction(), Fs1=2.0)
    assert np.all(np.sign(torque) == np.sign(velocity))
    assert abs(torque[1]) > abs(torque[0])
    velocity, torque = curve_with(fit, Hysteresis(), Fh1=3.0)
    np.testing.assert_allclose(torque, 3.0 * np.sign(velocity), rtol=1e-9)
    velocity, torque = curve_with(fit, LoadDependentFriction(), mu1=0.1)
    assert np.all(np.sign(torque) == np.sign(velocity))
    assert np.ptp(np.abs(torque)) < 1e-9
    velocity, torque = curve_with(fit, Hysteresis(), Off1=5.0, MX1=1.0, YY1=7.0)
    np.testing.assert_array_equal(torque, 0.0)
