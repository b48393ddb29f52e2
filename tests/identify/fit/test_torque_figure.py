"""The figure of a run: its legend lies over no curve."""

import pytest

from ...parts.pages.report_pages import known_fit


def test_the_legend_lies_outside_the_axes():
    pytest.importorskip("matplotlib").use("Agg")
    drawn = known_fit().plot()
    drawn.draw_without_rendering()
    [legend] = drawn.legends
    box = legend.get_window_extent()
    assert not any(box.overlaps(axes.get_tightbbox()) for axes in drawn.axes)
    assert [text.get_text() for text in legend.get_texts()] == ["measured", "predicted", "residual"]
