"""Criteria: what they mean, and gradients that are those of differences."""

from functools import partial

import numpy as np
import pytest

from exidyn.trajectories.search.goals import Focus, average, condition, volume, worst

from ...parts.plans.excitation import along

pytestmark = pytest.mark.numerical

COLUMNS = 7
UNBOUNDED = np.full(COLUMNS, np.inf)
"""Scales with which a condition number has all columns at norm one."""
CASES = {
    "condition": condition,
    "condition power 2": partial(condition, power=2.0),
    "condition power 8": partial(condition, power=8.0),
    "volume": volume,
    "average": average,
    "worst": worst,
    "worst power 4": partial(worst, power=4.0),
    "focus on some": Focus((1, 4, 5)),
    "focus on one": Focus((2,)),
    "focus on all": Focus(tuple(range(COLUMNS))),
}


def regressor(seed=0, rows=30):
    """Columns of very different size, correlated."""
    random = np.random.default_rng(seed)
    mix = np.eye(COLUMNS) + 0.3 * random.normal(size=(COLUMNS, COLUMNS))
    return random.normal(size=(rows, COLUMNS)) @ mix * 10.0 ** random.uniform(-2, 2, COLUMNS)


def sizes(seed=0):
    """Of parameters that make a tenth to ten of the noise."""
    share = 10.0 ** np.random.default_rng(100 + seed).uniform(-1, 1, COLUMNS)
    return share / np.linalg.norm(regressor(seed), axis=0)


def information(seed=0):
    matrix = regressor(seed)
    return matrix.T @ matrix


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("criterion", CASES.values(), ids=CASES.keys())
def test_gradient_is_that_of_differences(criterion, seed):
    """Along random symmetric directions that leave the matrix positive."""
    matrix, size = information(seed), sizes(seed)
    root = np.linalg.cholesky(matrix)
    half = np.random.default_rng(seed).normal(size=(COLUMNS, COLUMNS))
    direction = root @ (half + half.T) @ root.T
    expected = along(lambda m: criterion(m, size)[0], matrix, direction)
    gradient = criterion(matrix, size)[1]
    np.testing.assert_allclose(gradient, gradient.T, rtol=1e-6, atol=1e-12 * np.abs(gradient).max())
    assert np.sum(gradient * direction) == pytest.approx(expected, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("seed", range(2))
def test_condition_is_that_of_the_scaled_regressor(seed):
    matrix = regressor(seed)
    expected = np.linalg.cond(matrix / np.linalg.norm(matrix, axis=0))
    value = condition(matrix.T @ matrix, UNBOUNDED)[0]
    assert np.exp(value) == pytest.approx(expected, rel=1e-8)
    for power in (2.0, 8.0, 64.0):
        above = condition(matrix.T @ matrix, UNBOUNDED, power)[0]
        assert value <= above <= value + np.log(COLUMNS) / power + 1e-12


def test_a_small_column_is_not_scaled_to_one():
    """A column of a tenth of the least norm keeps a tenth: what it alone says counts ten times less."""
    matrix = np.linalg.qr(regressor())[0]
    size = np.full(COLUMNS, 1.0)
    assert condition(matrix.T @ matrix, size)[0] == pytest.approx(0.0, abs=1e-12)
    matrix[:, 3] *= 0.1
    assert condition(matrix.T @ matrix, size)[0] == pytest.approx(np.log(10.0), rel=1e-10)
    assert condition(matrix.T @ matrix, UNBOUNDED)[0] == pytest.approx(0.0, abs=1e-12)


def covariance(seed):
    """Of parameters in units of their size."""
    return np.linalg.inv(information(seed)) / np.outer(sizes(seed), sizes(seed))


@pytest.mark.parametrize("seed", range(2))
def test_deviations_are_those_of_the_inverse_and_a_focus_leaves_the_others_unknown(seed):
    matrix, size, found = information(seed), sizes(seed), covariance(seed)
    variance = np.diag(found)
    assert volume(matrix, size)[0] == pytest.approx(0.5 * np.linalg.slogdet(found)[1] / COLUMNS, rel=1e-6)
    assert average(matrix, size)[0] == pytest.approx(0.5 * np.log(np.mean(variance)), rel=1e-6)
    largest = 0.5 * np.log(np.max(variance))
    assert largest - 1e-9 <= worst(matrix, size)[0] <= largest + 0.5 * np.log(COLUMNS) / 16
    some = np.linalg.slogdet(found[np.ix_([1, 4], [1, 4])])[1]
    assert Focus((1, 4))(matrix, size)[0] == pytest.approx(0.25 * some, rel=1e-6)
    assert CASES["focus on all"](matrix, size)[0] == pytest.approx(volume(matrix, size)[0], rel=1e-6)


@pytest.mark.parametrize("name", CASES)
def test_units_do_not_matter_and_more_information_is_better_or_as_good(name):
    """A condition number does not count rows; everything else falls as a deviation does."""
    criterion, unmoved = CASES[name], name.startswith("condition")
    matrix, size = information(), UNBOUNDED if unmoved else sizes()
    gain = criterion(matrix, size)[0] - criterion(9 * matrix, size)[0]
    assert gain == pytest.approx(0.0 if unmoved else np.log(3.0), abs=1e-8)
    size, unit = sizes(), 10.0 ** np.linspace(-2, 2, COLUMNS)
    other = criterion(matrix * np.outer(unit, unit), size / unit)[0]
    assert other == pytest.approx(criterion(matrix, size)[0], rel=1e-6, abs=1e-8)


@pytest.mark.parametrize("criterion", CASES.values(), ids=CASES.keys())
def test_two_columns_that_cannot_be_distinguished_are_bad_but_a_number(criterion):
    """A start may leave them so: the solver must still see a number and a way out."""
    matrix, size = regressor(), sizes()
    matrix[:, 5] = 2.0 * matrix[:, 1]
    value, gradient = criterion(matrix.T @ matrix, size)
    assert np.all(np.isfinite([value, *gradient.ravel()]))
    touched = not isinstance(criterion, Focus) or criterion.columns != (2,)
    if touched:
        assert value > criterion(information(), size)[0] + 1.0
