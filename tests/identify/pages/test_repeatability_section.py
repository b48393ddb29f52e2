"""What the page says of agreement: also how little may have been compared."""

from exidyn.identification.fit.repeatability import Part, Repeatability, Repeated
from exidyn.identification.pages.repeatability_section import repeatability_section

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
