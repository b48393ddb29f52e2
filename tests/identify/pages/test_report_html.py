"""Pieces of a page: text is escaped wherever it stands, and HTML is left as it is."""

import re

import numpy as np
from markupsafe import Markup

from exidyn.identify.pages.combined.material import Material, Run
from exidyn.identify.pages.combined.runs import runs_sections
from exidyn.identify.pages.report_html import figure, grid, listing, number, paragraph, section, table, unit
from exidyn.identify.pages.report_page import Chapter, page


def test_text_is_escaped_and_html_is_not():
    cells = ["<td>joint", Markup('<td class="bad">2</td>'), number(-0.5), "a & b"]
    found = table(["<i>", "b", "c", "d"], [cells], words=(3,))
    assert "<th>&lt;i&gt;</th>" in found
    assert '<td>&lt;td&gt;joint</td><td class="bad">2</td><td><data value="-0.5">' in found
    assert '<td class="words">a &amp; b</td></tr>' in found
    assert listing(["1 < 2"], "verdict") == '<ul class="verdict"><li>1 &lt; 2</li></ul>'
    assert paragraph("5 % of <b>") == '<p class="note">5\N{NO-BREAK SPACE}% of &lt;b&gt;</p>'
    assert figure("<u>", "3 x noise", "<svg/>") == (
        "<figure><figcaption>&lt;u&gt;<small>3 \N{MULTIPLICATION SIGN} noise</small></figcaption>"
        "<svg/></figure>"
    )
    assert grid("<p></p>", kind="three") == '<div class="grid three"><p></p></div>'


def test_a_page_links_to_its_sections_and_those_of_its_chapters():
    opening, runs = section("verdict", "A & B", "<p></p>"), section("motion", "Motion")
    text = page(
        "title <", "heading", "note &", opening, [Chapter("runs", "Runs", runs), Chapter("no", "", "")]
    )
    assert "<title>title &lt;</title>" in text
    assert '<p class="note">note &amp;</p>' in text
    assert '<li><a href="#verdict">A &amp; B</a></li>' in text
    assert '<li><a class="part" href="#runs">Runs</a><a href="#runs-motion">Motion</a></li>' in text
    assert '<div class="chapter" id="runs"><h1>Runs</h1><section id="runs-motion">' in text
    assert 'id="no"' not in text
    assert '<nav><a href="#verdict">A &amp; B</a></nav>' in page("t", "h", "n", opening)


def test_units_have_raised_exponents():
    assert [unit("N m/rad^3"), unit("kg m^2")] == ["N m/rad³", "kg m²"]


def test_names_of_joints_stand_clear_of_the_scales_beside_them():
    time, values = np.linspace(0.0, 1.0, 20), np.linspace(-12.5, 13.5, 20)[:, None]
    run = Run("run", "fitted", "", 20.0, time, values, time, values, "torque", ())
    drawn = {
        name: runs_sections(Material((name,), None, (run,), (), None, (), {}))
        for name in ("j1", "shoulder_lift_joint")
    }
    frames = {name: float(re.search(r'class="frame" x="([\d.]+)"', text)[1]) for name, text in drawn.items()}
    assert frames["shoulder_lift_joint"] - frames["j1"] > 30
