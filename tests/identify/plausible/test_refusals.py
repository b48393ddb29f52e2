"""What init refuses of a log, in the words of the import."""

import numpy as np
import pytest

from exidyn.identification.errors import NotFinite
from exidyn.identification.model import Model
from exidyn.identification.plausible.proposal import propose

from ...parts.small import two_joints

NAMES = ("t", "q1", "q2", "tau1", "tau2")


@pytest.mark.parametrize("place", range(len(NAMES)))
@pytest.mark.parametrize("value", [1e308, -1e308, 1e16])
def test_numbers_that_cannot_be_computed_with_are_refused(place, value):
    time = np.arange(0.0, 4.0, 0.01)
    values = np.column_stack([time, np.sin(time), np.cos(time), np.cos(3 * time), np.sin(2 * time)])
    values[-1, place] = abs(value) if place == 0 else value
    expected = rf"column {NAMES[place]} is above 1e\+15 in 1 of 400 rows, first in row 400"
    with pytest.raises(NotFinite, match=expected):
        propose(NAMES, values, Model(two_joints.arm(), ()))
