"""Marks of an axis: a power of ten within reach of what is shown."""

import math

import numpy as np
import pytest

from exidyn.acquire.views.residual import MARKS, Scale


@pytest.mark.parametrize(
    ("values", "mark"),
    [([-3.0, 5.0], 1.0), ([-3.0, 5.1], 10.0), ([-800.0, 1400.0], 1e3), ([0.02], 0.01), ([-450.0, 0.0], 1e2)],
)
def test_a_power_of_ten_is_marked_that_an_axis_has_room_for(values, mark):
    found = Scale(15.0).add(np.zeros(1), np.array([values]))
    assert found == pytest.approx(mark)
    assert np.ptp([*values, 0.0]) <= MARKS * found < 10.0 * np.ptp([*values, 0.0])


def test_what_is_no_longer_shown_is_forgotten():
    scale = Scale(15.0)
    scale.add(np.array([0.0]), np.array([[1e3]]))
    assert scale.add(np.array([14.0]), np.array([[1.0]])) == pytest.approx(1e3)
    assert scale.add(np.array([16.0]), np.array([[1.0]])) == pytest.approx(1.0)


def test_nothing_is_marked_where_nothing_is_known():
    scale = Scale(15.0)
    assert math.isnan(scale.add(np.zeros(1), np.full((1, 2), np.nan)))
    assert math.isnan(scale.add(np.ones(1), np.zeros((1, 2))))
