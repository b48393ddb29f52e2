"""Return of insignificant values to the nominal ones, and what that does to the others."""

import numpy as np
import pytest

from exidyn.identification.fit.estimators.consistent import of_pseudo_inertia, possible_body, pseudo_inertia
from exidyn.identification.fit.needed_changes import with_needed_changes

SINGLE = [np.array([0]), np.array([1]), np.array([2])]


def test_values_within_their_interval_return_and_others_follow():
    """Against a least-squares fit in which the returned value is fixed."""
    rng = np.random.default_rng(0)
    columns, true = rng.normal(size=(200, 3)), np.array([2.0, 0.0, 0.0])
    columns[:, 1] += 0.8 * columns[:, 0]
    rows = columns @ true + 0.5 * rng.normal(size=200)
    information = columns.T @ columns / 0.25
    estimate, covariance = np.linalg.solve(information, columns.T @ rows / 0.25), np.linalg.inv(information)
    values, spread = with_needed_changes(estimate, covariance, np.zeros(3), SINGLE)
    assert values[1] == values[2] == 0.0
    assert values[0] == pytest.approx(np.linalg.lstsq(columns[:, :1], rows, rcond=None)[0][0], rel=1e-9)
    assert spread[0, 0] == pytest.approx(0.25 / np.sum(columns[:, 0] ** 2), rel=1e-9)


def test_significant_values_and_groups_stay_as_a_whole():
    values, _ = with_needed_changes(np.array([1.0, 5.0, -3.0]), np.eye(3), np.array([0.5, 0.0, 0.0]), SINGLE)
    np.testing.assert_array_equal(values, (0.5, 5.0, -3.0))
    groups = [np.array([0, 1]), np.array([2])]
    values, _ = with_needed_changes(np.array([6.0, 0.1, 0.1]), np.eye(3), np.zeros(3), groups)
    np.testing.assert_array_equal(values, (6.0, 0.1, 0.0))


def test_one_of_twenty_groups_without_changes_is_kept_by_chance_at_most():
    """The 5 % of a family hold: estimates of zero, 150 times."""
    rng, kept = np.random.default_rng(1), 0
    groups = [np.array([place]) for place in range(20)]
    for _ in range(150):
        values, _ = with_needed_changes(rng.normal(size=20), np.eye(20), np.zeros(20), groups)
        kept += bool(np.any(values))
    assert kept < 150 * (0.05 + 3.0 * np.sqrt(0.05 * 0.95 / 150))


def test_an_impossible_body_becomes_the_nearest_possible_one():
    root = np.random.default_rng(0).normal(size=(4, 4)) * [0.1, 0.1, 0.1, 1.0]
    body = of_pseudo_inertia(root.T @ root)
    np.testing.assert_allclose(possible_body(body), body)
    body[0] = -1e-3
    nearest = possible_body(body)
    assert np.linalg.eigvalsh(pseudo_inertia(body))[0] < 0.0 < np.linalg.eigvalsh(pseudo_inertia(nearest))[0]
    assert nearest[9] == pytest.approx(body[9], rel=0.1)
