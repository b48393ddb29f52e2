"""Separations by products of columns: as least squares finds them, and none where columns coincide."""

import numpy as np
import pytest

from exidyn.identification.diagnosis.belief.belief import Stance, separations
from exidyn.identification.diagnosis.questions.candidate_fit import FORMULA

COLUMNS = 1e-3 * np.random.default_rng(0).normal(size=(40, 4))
"""Torque over 40 rows of one unknown that all share, of two suspects, and of a third like the second; small
beside the noise, so that an error of the formula does not matter."""
COLUMNS[:, 3] = COLUMNS[:, 2] + 1e-9 * COLUMNS[:, 1]
GRAM = COLUMNS.T @ COLUMNS


def stance(held, own, precision=4e-6):
    """Beside the first unknown, with coefficients of its own that are known."""
    ways = np.zeros((4, 1))
    ways[held[1:], 0] = own
    return Stance(np.array(held), np.full(len(held), precision), np.zeros(4), ways)


def least(true, rival, columns=COLUMNS):
    """The same by a solution of all rows and priors at once."""
    torque = columns @ true.variations.sum(axis=1)
    root = np.diag(np.sqrt(rival.precision))
    matrix = np.concatenate([columns[:, rival.held], root])
    right = np.concatenate([torque, np.zeros(len(rival.held))])
    return np.linalg.lstsq(matrix, right, rcond=None)[1][0]


def test_a_separation_is_the_chi_squared_that_the_rival_keeps():
    one, other = stance([0, 1], [2.0]), stance([0, 2], [-1.0])
    found = separations([one, other], GRAM)
    assert found[0, 1] == pytest.approx(least(one, other), rel=1e-5)
    assert found[1, 0] == pytest.approx(least(other, one), rel=1e-5)
    assert np.all(np.diag(found) == 0.0)


def test_columns_that_coincide_separate_nothing():
    one, other = stance([0, 2], [2.0], 1e-15), stance([0, 3], [2.0], 1e-15)
    assert np.max(separations([one, other], GRAM)) < 1e-6 * np.sum((2.0 * COLUMNS[:, 2]) ** 2)


def test_what_is_not_known_of_an_effect_counts_as_its_spread():
    there, nothing = stance([0, 1], [0.0]), stance([0], [])
    assert separations([there, nothing], GRAM)[0, 1] == 0.0
    spread = there._replace(variations=np.column_stack([there.variations, [0.0, 0.5, 0.0, 0.0]]))
    assert separations([spread, nothing], GRAM)[0, 1] == pytest.approx(least(spread, nothing), rel=1e-5)


def test_runs_separate_by_their_length_up_to_the_error_of_a_formula():
    one, other = stance([0, 1], [2.0], 1e-15), stance([0, 2], [-1.0], 1e-15)
    once, twice = (separations([one, other], runs * GRAM) for runs in (1.0, 2.0))
    assert twice[0, 1] == pytest.approx(2.0 * once[0, 1], rel=1e-3)
    one, other = stance([0, 1], [2.0], 1e-15), stance([0, 2], [-1.0], 1e-15)
    torque = 2.0 * COLUMNS[:, 1]
    share = least(one, other) / (torque @ torque)
    assert separations([one, other], 1e12 * GRAM)[0, 1] == pytest.approx(share / FORMULA**2, rel=1e-3)
