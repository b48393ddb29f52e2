"""The page that a person reads."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.fit.fit import Unclear
from exidyn.identification.fit.fit_file import read_fit, write_fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.repeatability import Part, Repeatability, Repeated
from exidyn.identification.pages.fit_parameters import repeatability_section
from exidyn.identification.recordings.recording import Signal
from exidyn.identification.text_table import WIDTH, at_point, digits, fixed, paragraph, table

from ...parts.small.small_fit import fit, plain_fit, summary
from ...parts.small.two_joint_files import run


def section(text: str, title: str) -> list[str]:
    """Lines of a section."""
    lines = text.splitlines()
    start = lines.index(title) + 2
    return lines[start : lines.index("", start) if "" in lines[start:] else None]


def row(lines: list[str], name: str) -> list[str]:
    """Cells of a row; of a table whose last columns stand below, those of the first."""
    found, *below = [line.split() for line in lines if line.split()[:1] == [name]]
    assert all(other[:2] == found[:2] for other in below)
    return found


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1.0, "1.000"),
        (-78500.4, "-78500"),
        (0.00123456, "0.001235"),
        (123.456, "123.5"),
        (9.9999, "10.00"),
        (1.234e-7, "1.234e-7"),
        (1.234e9, "1.234e9"),
        (np.inf, "-"),
        (np.nan, "-"),
    ],
)
def test_numbers_have_four_significant_digits(value, text):
    assert digits(value) == text


def test_numbers_and_texts_stand_on_the_page():
    assert [fixed(value, 2) for value in (-0.004, -0.006, 0.0, np.inf)] == ["0.00", "-0.01", "0.00", "inf"]
    texts = at_point([digits(v) for v in (50400.0, -1.5, 0.0123)])
    wide = [text.rjust(20) for text in texts]
    assert wide[1].index(".") == wide[2].index(".") == len(wide[0].rstrip())
    assert table(["a", "bb"], [["one", "1"], ["heading"], ["x", "22"]]) == [
        "a    bb",
        "one   1",
        "heading",
        "x    22",
    ]
    lines = paragraph("word " * 100, "    ", "- ")
    assert max(map(len, lines)) <= WIDTH
    assert lines[0].startswith("- word")
    assert all(line.startswith("    word") for line in lines[1:])
    for each in (fit(), plain_fit()):
        lines = summary(each).splitlines()
        assert max(map(len, lines)) <= WIDTH
        assert all(line == line.rstrip() for line in lines)


def test_the_head_reports_what_was_done():
    head = summary(fit()).partition("Verdict")[0]
    for words in (
        "Identified dynamics of two joints",
        "1 shoulder, 2 elbow",
        "maximum likelihood",
        f"{len(fit().names) + len(fit().dropped)} identifiable, {len(fit().names)} kept",
        "Identified from:  empty, loaded",
        "Validated on:     other",
    ):
        assert words in head
    filters = section(summary(fit()), "Filters")
    assert f"{digits(fit().filtering.torque_cutoff)} Hz" in " ".join(" ".join(filters).split())


def test_gains_are_printed_with_interval_and_prior_or_what_they_need():
    name, gain, half, unit, _, nominal, tolerance, off = row(section(summary(fit()), "Drive gains"), "elbow")
    assert (name, unit) == ("elbow", "N")
    assert float(gain) == pytest.approx(fit().estimate.gain[1], rel=1e-3)
    assert float(half) == pytest.approx(1.96 * fit().estimate.gain_std[1], rel=0.05)
    assert float(nominal) == pytest.approx(27.5)
    assert float(tolerance) == pytest.approx(
        1.96 * 27.5 * fit().model.robot.drive_gain_tolerance[1], rel=0.05
    )
    assert float(off) == pytest.approx(100 * (fit().estimate.gain[1] / 27.5 - 1), rel=0.05)
    page = summary(plain_fit())
    assert "record motor currents and a run with a known payload" in " ".join(page.split())
    assert float(row(section(page, "Drive gains"), "shoulder")[1]) == pytest.approx(
        plain_fit().estimate.gain[0], rel=1e-4
    )


def test_recorded_torque_has_no_gains():
    recording = run("torque")
    current = recording.signals["current"]
    signals = {name: s for name, s in recording.signals.items() if name != "current"}
    signals["torque"] = Signal(current.time, current.values * [-40.0, 25.0])
    text = summary(identify([replace(recording, signals=signals)]))
    assert " ".join(text.split()).count("Torque was recorded and taken as measured") == 1


def test_every_kept_parameter_has_a_row_under_its_effect_and_every_dropped_one_is_listed():
    text = summary(fit())
    lines = section(text, "Parameters")
    for place, name in enumerate(fit().names):
        found = row(lines, name)
        value = next(float(cell) for cell in found[1:] if cell.lstrip("-")[0].isdigit())
        assert value == pytest.approx(fit().estimate.values[place], rel=1e-3, abs=1e-7)
    assert "payload L" in lines
    assert fit().dropped
    dropped = text.partition("\nDropped\n")[2].partition("\nRuns\n")[0]
    assert all(f"{name} " in dropped for name in fit().dropped)


def test_far_from_prior_is_pointed_out():
    value, std = fit().estimate.values, fit().estimate.std
    near = replace(fit(), prior=(value + 2.9 * std, 0 * std))
    far = replace(fit(), prior=(value + 3.1 * std, 0 * std))
    nothing = replace(fit(), prior=(value + 3.1 * std, np.full(len(std), np.inf)))
    marks = [
        "\n".join(section(summary(each), "Parameters")).count(" off nominal\n")
        for each in (near, far, nothing)
    ]
    assert marks == [0, len(value), 0]


def test_what_remains_open_is_listed_with_the_motion_that_would_settle_it():
    unclear = (Unclear("MX2", 45.678, "move elbow fast"),)
    page = summary(replace(fit(), unclear=unclear)).partition("\nUncertain\n")[2].splitlines()
    assert page[1].split() == ["MX2", "45.7", "move", "elbow", "fast"]
    assert "Uncertain" not in summary(replace(fit(), unclear=()))


def test_a_fit_that_was_read_has_a_page_too(tmp_path):
    write_fit(fit(), tmp_path / "fit.json")
    text = summary(read_fit(tmp_path / "fit.json"))
    assert "loaded without the samples" in " ".join(section(text, "Runs"))
    assert section(text, "Parameters") == section(summary(fit()), "Parameters")


@pytest.mark.parametrize("columns", [3, 9, 14])
def test_a_table_fits_the_page_and_loses_no_cell(columns):
    head = ["joint", *(f"a quantity {k}" for k in range(columns))]
    rows = [[name, *(f"{k}.{place}25" for k in range(columns))] for place, name in enumerate(("one", "two"))]
    lines = table(head, rows)
    assert max(map(len, lines)) <= WIDTH
    words = " ".join(lines).split()
    assert all(words.count(cell) == 1 for row in rows for cell in row[1:])


PARTS = (Part("monday", 0.0, 30.0, {}), Part("tuesday", 0.0, 30.0, {}))


def sentence(*std):
    """The first sentence for parameters of the value 1 with a standard deviation in each part."""
    repeated = [
        Repeated(f"P{k}", "kg", (1.0, 1.0), (value, value), 1.0, 0.0, 0.5) for k, value in enumerate(std)
    ]
    return repeatability_section(Repeatability(PARTS, tuple(repeated)), "unit").blocks[0].sentences[0]


def test_agreement_of_what_no_part_determines_is_no_evidence():
    assert "A part alone determines 0 of the 2 to 30 % or better" in sentence(0.5, 3.0)
    text = sentence(0.01, 0.29, 0.31)
    assert text.startswith("All 3 base parameters agree between 2 runs")
    assert "A part alone determines 2 of the 3 to 30 % or better" in text
