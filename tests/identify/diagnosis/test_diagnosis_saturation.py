"""A saturating drive gain: what it takes from the torque, and that no motor gives less for more current."""

import numpy as np
import pytest

from exidyn.identify.diagnosis.candidates.drive_gain_saturation import saturations

from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import problem, record


@pytest.mark.parametrize("width", [0.02, 0.2, 5.0])
def test_torque_rises_with_current_and_falls_behind_it_beyond_the_knee(width):
    run = problem(record(roles=("identify",))).runs[0]
    first = next(iter(saturations(nominal_model())))
    lost = -first.reshaped({"knee": 0.4, "width": width}).columns(run)[:, 0, 0]
    asked, most = run.torque[:, 0], run.most[0]
    order = np.argsort(asked)
    given = (asked - np.abs(lost) * np.sign(asked))[order]
    assert np.all(np.diff(given) >= -1e-9 * most)
    below = np.abs(asked) <= 0.4 * most
    np.testing.assert_array_equal(lost[below], 0.0)
    assert np.all(np.abs(lost[~below]) > 0.0)
    assert first.most == 1.0
