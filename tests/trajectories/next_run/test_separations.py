"""Separations by products of columns: as least squares finds them, and none where columns coincide."""

import numpy as np
import pytest

from exidyn.trajectories.next_run.belief import Stance
from exidyn.trajectories.next_run.forecast import Information, separations

COLUMNS = np.random.default_rng(0).normal(size=(40, 4))
"""Torque over 40 rows of one unknown that all share, of two suspects, and of a third like the second."""
COLUMNS[:, 3] = COLUMNS[:, 2] + 1e-9 * COLUMNS[:, 1]
SEEN = Information(COLUMNS.T @ COLUMNS)


def stance(held, own, precision=4.0):
    """Known to 1 / sqrt(precision), without a way in which coefficients may differ."""
    values = np.zeros(4)
    values[held] = own
    held = np.array(held)
    return Stance(held, precision * np.eye(len(held)), values, np.zeros((4, 0)))


def least(true, rival):
    """The same by a solution of all rows and priors at once."""
    torque = COLUMNS @ true.values
    root = np.linalg.cholesky(rival.precision).T
    matrix = np.concatenate([COLUMNS[:, rival.held], root])
    right = np.concatenate([torque, root @ rival.values[rival.held]])
    return np.linalg.lstsq(matrix, right, rcond=None)[1][0]


def test_a_separation_is_the_chi_squared_that_the_rival_keeps():
    one, other = stance([0, 1], [1.0, 2.0]), stance([0, 2], [1.2, -1.0])
    found = separations([one, other], SEEN)
    assert found[0, 1] == pytest.approx(least(one, other), rel=1e-6)
    assert found[1, 0] == pytest.approx(least(other, one), rel=1e-6)
    assert np.all(np.diag(found) == 0.0)


def test_columns_that_coincide_separate_nothing():
    one, other = stance([0, 2], [1.0, 2.0], 1e-9), stance([0, 3], [1.0, 2.0], 1e-9)
    assert np.all(separations([one, other], SEEN) == 0.0)


def test_what_is_not_known_of_an_effect_counts_as_its_spread():
    there, nothing = stance([0, 1], [0.0, 0.0]), stance([0], [0.0])
    ways = np.zeros((4, 1))
    ways[1] = 0.5
    assert separations([there, nothing], SEEN)[0, 1] == 0.0
    spread = there._replace(ways=ways)
    moved = there._replace(values=ways[:, 0])
    assert separations([spread, nothing], SEEN)[0, 1] == pytest.approx(least(moved, nothing), rel=1e-6)


def test_twice_the_run_is_twice_the_chi_squared_where_priors_are_loose():
    one, other = stance([0, 1], [1.0, 2.0], 1e-9), stance([0, 2], [1.0, -1.0], 1e-9)
    once, twice = (separations([one, other], SEEN.times(runs)) for runs in (1.0, 2.0))
    assert twice[0, 1] == pytest.approx(2.0 * once[0, 1], rel=1e-6)
