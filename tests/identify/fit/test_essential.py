import numpy as np
import pytest
from scipy import stats

from exidyn.identification.fit.estimators import Estimate
from exidyn.identification.fit.settled_gains import unsupported

pytestmark = pytest.mark.numerical


def estimate(values, covariance):
    values = np.asarray(values, float)
    full = np.pad(np.asarray(covariance, float), (0, 2))
    return Estimate("test", values, np.ones(2), full, np.ones(2))


def test_values_go_together_from_the_weakest():
    found = unsupported(estimate([5.0, 1.4, -1.6, 0.1], np.eye(4)))
    assert found == [3, 1, 2]  # 0.01 + 1.96 + 2.56 is below 7.8, the 95 % quantile with three
    found = unsupported(estimate([1.5] * 10 + [100.0], np.eye(11)))
    squares, limits = 1.5**2 * np.arange(1, 12), stats.chi2.ppf(0.95, np.arange(1, 12))
    assert len(found) == np.flatnonzero(squares > limits)[0] == 4


@pytest.mark.parametrize(("value", "dropped"), [(1.9, [0]), (2.0, [])])
def test_one_value_goes_below_two_deviations(value, dropped):
    assert stats.norm.ppf(0.975) == pytest.approx(1.96, abs=0.01)
    assert unsupported(estimate([3 * value, 50.0], np.diag([9.0, 1.0]))) == dropped


def test_two_that_cannot_be_distinguished_go_only_if_they_cancel():
    # Their sum is known well: once one is zero, the other is all of it.
    apart, together = np.array([1.0, -1.0]), np.array([1.0, 1.0])
    covariance = 100.0 * np.outer(apart, apart) + 0.01 * np.outer(together, together)
    found = unsupported(estimate([2.0, 3.0], covariance))
    assert found == [0]
    # Their sum is known well, and nearly zero: once one is zero, so is the other.
    covariance = np.diag([0.0, 0.0, 1.0])
    covariance[:2, :2] = 100.0 * np.array([[1, -1], [-1, 1]]) + 0.01
    assert unsupported(estimate([2.0, -2.1, 50.0], covariance)) == [0, 1]


def test_dropping_is_least_squares_without_the_columns():
    """The statistic is that of the restricted fit: residual squares grow by it."""
    random = np.random.default_rng(0)
    rows = random.normal(size=(60, 6)) @ random.normal(size=(6, 6))
    values = np.array([4.0, 0.02, 3.0, -0.01, 0.015, 5.0])
    right = rows @ values + 0.1 * random.normal(size=60)
    full = np.linalg.lstsq(rows, right, rcond=None)[0]
    covariance = 0.01 * np.linalg.inv(rows.T @ rows)
    dropped = unsupported(estimate(full, covariance))
    assert dropped
    for count in (len(dropped), len(dropped) + 1):
        left = [k for k in range(6) if k not in dropped[:count]]
        if count > len(dropped):  # the next weakest would be too much
            part = np.linalg.lstsq(rows[:, left], right, rcond=None)[0]
            ratio = np.abs(part) / np.sqrt(0.01 * np.diag(np.linalg.inv(rows[:, left].T @ rows[:, left])))
            left.pop(int(np.argmin(ratio)))
        part = np.linalg.lstsq(rows[:, left], right, rcond=None)[0]
        growth = np.sum((right - rows[:, left] @ part) ** 2) - np.sum((right - rows @ full) ** 2)
        assert (growth / 0.01 < stats.chi2.ppf(0.95, count)) == (count == len(dropped))
