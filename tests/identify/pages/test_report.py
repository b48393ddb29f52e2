"""The report: its numbers are the fit's, its pictures are finite, and it needs nothing else."""

import re
from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.pages.fit_document import report_html

from ...parts.pages.report_pages import Page, dots_of, known_fit, points_of


@pytest.fixture(scope="module")
def fit():
    return known_fit()


def page_of(fit, tmp_path):
    (tmp_path / "report.html").write_text(report_html(fit), encoding="utf-8")
    return Page((tmp_path / "report.html").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def page(fit, tmp_path_factory):
    return page_of(fit, tmp_path_factory.mktemp("report"))


def bare(fit):
    """The fit as it comes back without samples."""
    return replace(fit, agreement=(), validation=())


def values_of(row, *columns):
    return [row[column][1][0] for column in columns]


def test_links_lead_to_sections_and_nothing_elsewhere(page, fit, tmp_path):
    tags = {tag for tag, _ in page.elements}
    assert not tags & {"script", "link", "img", "iframe", "object", "base", "use", "image"}
    for _, attrs in page.elements:
        assert not {"src", "srcset", "data", "xlink:href", "onload"} & set(attrs)
        assert attrs.get("href", "#").startswith("#")
    (tmp_path / "report.html").write_text(report_html(fit), encoding="utf-8")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert not re.search(r"https?:|//|url\(|@import|@font-face", text)
    assert len(text.encode()) < 2e6
    anchors = {attrs["id"] for tag, attrs in page.elements if tag == "section"}
    links = [attrs["href"][1:] for tag, attrs in page.elements if tag == "a"]
    assert len(links) == 8
    assert set(links) == anchors


def test_values_are_shown_as_they_are(page, fit):
    estimate, (nominal, deviation) = fit.estimate, fit.prior
    for k, name in enumerate(fit.names):
        row = page.row("parameters", name)
        value, half = values_of(row, 1, 2)
        assert value == estimate.values[k]
        assert half == pytest.approx(1.96 * estimate.std[k], rel=1e-12)
        assert row[3][0] == fit.base.units[k].replace("^2", "²")
        if np.isfinite(deviation[k]):
            assert values_of(row, 4, 5) == [nominal[k], pytest.approx(1.96 * deviation[k], rel=1e-12)]
        else:
            assert row[4][1] == row[5][1] == []
    for k, joint in enumerate(fit.model.robot.joints):
        row = page.row("gains", joint)
        gain, half, prior = values_of(row, 1, 2, 4)
        assert gain == fit.estimate.gain[k]
        assert half == pytest.approx(1.96 * fit.estimate.gain_std[k], rel=1e-12)
        assert prior == fit.model.robot.drive_gain[k]
    assert len(page.data) > 80
    for value, text in page.data:
        shown = float(text.replace("\N{MINUS SIGN}", "-"))
        assert shown == pytest.approx(value, rel=0.051, abs=0)  # two digits at least


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


def test_worst_pairs_are_correlated_as_stated(page, fit):
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


def test_fit_without_samples_reports_it(fit, tmp_path):
    page = page_of(bare(fit), tmp_path)
    assert "loaded without the samples" in page.words
    assert "torque and residual over time" not in page.words
    assert "friction over velocity" in page.words
    assert page.row("parameters", fit.names[0])[1][1] == [fit.estimate.values[0]]


def test_names_cannot_break_the_page(fit, tmp_path):
    odd = replace(fit, validation=(replace(fit.validation[0], run="<b>&"),), warnings=("1 < 2 & <i>3",))
    page = page_of(odd, tmp_path)
    assert "<b>&" in page.words
    assert "1 < 2 & <i>3" in page.words
    assert not {"b", "i"} & {tag for tag, _ in page.elements}
