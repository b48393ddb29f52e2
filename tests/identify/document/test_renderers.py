"""One document, three renderers: the same numbers and words, escaped wherever they stand."""

import numpy as np
import pytest

from exidyn.identification.document.document import (
    Document,
    Figure,
    Grid,
    Heading,
    Marked,
    Number,
    Numbers,
    Paragraph,
    Picture,
    Section,
    Statements,
    Table,
)
from exidyn.identification.document.html import html
from exidyn.identification.document.text import section_markdown, text
from exidyn.identification.text_table import page_width, percent, table

TABLE = Table(
    ["joint", "value", "± 95 %", "verdict", "plot"],
    [
        ["arm"],
        ["a & b", Number(-0.5), Number(1234.5, 3, "N m"), Marked("far", "bad", "too far"), Picture("<svg/>")],
        ["<i>", Number(np.nan), Numbers("{}; {} %", (Number(1.0, 2), Number(2.5, 2))), "", Picture("")],
    ],
    words=(3, 4),
)
DOCUMENT = Document(
    "title <",
    "note &",
    [
        Section("verdict", "A & B", [Statements(["5 % of <b>", "-> 3 x noise"], "verdict"), TABLE]),
        Section("plots", "Plots", [Heading("of a run"), Grid([Figure("one", "remark", "<svg></svg>")])]),
        Section("detail", "Detail", [Paragraph("only in the report")], detail=True),
        Section("empty", "Empty", []),
    ],
    [("Robot", "x & y")],
)


def test_a_page_escapes_text_and_links_to_its_sections():
    page = html(DOCUMENT)
    assert "<title>title &lt;</title>" in page
    assert '<p class="note">note &amp;</p>' in page
    assert '<data value="-0.5">\N{MINUS SIGN}0.5000</data>' in page
    assert '<data value="1234.5">1234</data> N m' in page
    assert '<td class="bad words" title="too far">far</td>' in page
    assert "a &amp; b" in page
    assert "&lt;i&gt;" in page
    assert '<ul class="verdict"><li>5\N{NO-BREAK SPACE}% of &lt;b&gt;</li>' in page
    assert "<dt>Robot</dt><dd>x &amp; y</dd>" in page
    assert 'id="empty"' not in page
    assert '<nav><a href="#verdict">A &amp; B</a>' in page


def test_text_and_markdown_have_every_number():
    lines = text(DOCUMENT).splitlines()
    assert max(map(len, lines)) <= 80
    assert not {"of a run", "Plots", "Detail", "Empty"} & set(lines)
    [row] = [line for line in lines if line.startswith("a & b")]
    assert row.split() == ["a", "&", "b", "-0.5000", "1234", "N", "m", "far"]
    assert "plot" not in next(line for line in lines if line.startswith("joint"))
    written = section_markdown(DOCUMENT.sections[0])
    assert "| a & b | -0.5000 | 1234 N m | far |" in written
    assert "- -> 3 x noise" in written
    assert "svg" not in written


@pytest.mark.parametrize(
    ("share", "shown"),
    [
        (0.0, "0 %"),
        (0.0004, "below 0.1 %"),
        (0.031, "3.1 %"),
        (0.82, "82 %"),
        (0.996, "99.6 %"),
        (0.9995, "above 99.9 %"),
        (-0.05, "-5 %"),
    ],
)
def test_shares_never_round_to_nothing_or_all(share, shown):
    assert percent(share) == shown


def test_a_column_of_words_is_not_lost_beside_wide_names():
    rows = [["a long name " * 5, "1", "no: " + "a long reason " * 6]]
    lines = "\n".join(table(["added", "error", "written"], rows, left=(0, 2)))
    assert "written" in lines
    assert "no: a long reason" in lines


def test_pages_have_the_width_of_the_terminal():
    longest = max(map(len, text(DOCUMENT).splitlines()))
    before = page_width.set(110)
    try:
        wide = text(DOCUMENT).splitlines()
    finally:
        page_width.reset(before)
    assert wide[1] == "=" * 110
    assert longest <= 80 < max(map(len, wide)) <= 110
