"""A saturating drive gain: what it takes from the current, from a knee on or below a ceiling."""

import numpy as np
import pytest

from exidyn.identification.diagnosis.candidates.drives import saturations

from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import sound_problem


@pytest.fixture(scope="module")
def run():
    return sound_problem().runs[0]


def candidate(name):
    return next(one for one in saturations(nominal_model()) if name in one.shape)


def lost(one, run, **shape):
    """Current that is lost by each torque, over the largest torque."""
    torque, most = run.torque[:, 0], run.most[0]
    return torque / most, one.reshaped(shape).columns(run)[:, 0, 0] / most


@pytest.mark.parametrize("width", [0.02, 0.2, 5.0])
def test_nothing_is_lost_up_to_the_knee_and_more_and_more_beyond_it(run, width):
    torque, current = lost(candidate("knee"), run, knee=0.4, width=width)
    below = np.abs(torque) <= 0.4
    np.testing.assert_array_equal(current[below], 0.0)
    order = np.argsort(np.abs(torque[~below]))
    assert np.all(np.diff((current * np.sign(torque))[~below][order]) >= 0.0)
    beyond = np.abs(torque[~below]) - 0.4
    assert np.all(np.abs(current[~below]) <= beyond)


@pytest.mark.parametrize("saturation", [1.15, 1.5, 3.0])
def test_a_ceiling_is_near_the_inverse_of_a_hyperbolic_tangent(run, saturation):
    """Torque that is the hyperbolic tangent of the current is the usual formula of iron without a bias."""
    torque, _ = lost(candidate("ceiling"), run, ceiling=2.0)
    true = saturation * np.arctanh(torque / saturation) - torque

    def left(ceiling):
        column = lost(candidate("ceiling"), run, ceiling=ceiling)[1]
        return np.linalg.norm(true - column * (column @ true) / (column @ column)) / np.linalg.norm(true)

    assert min(left(ceiling) for ceiling in np.linspace(1.05, 4.0, 60)) < 0.02
