"""Do intervals hold the truth as often as stated? A hundred draws of coloured noise, same motion."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.fit.estimators import consistent, maximum_likelihood, weighted
from exidyn.identification.fit.estimators.least_squares import given_nominal

from ...parts.small.two_joints import GAIN, coloured, equations

pytestmark = pytest.mark.slow

DRAWS = 100
WIDE = 1.96
"""Deviations either side that hold 95 % of a normal distribution."""


def draws(exact):
    random = np.random.default_rng(42)
    for _ in range(DRAWS):
        noise = [coloured(rows.stop - rows.start, random) for rows in exact.runs]
        yield replace(exact, current=exact.current + np.concatenate(noise))


def held(errors, deviations):
    """Share of intervals that hold the truth."""
    return np.mean(np.abs(errors) < WIDE * deviations)


def tolerance(parameters):
    """Three deviations of the share; parameters of a draw are correlated, and half of them count."""
    return 3 * np.sqrt(0.95 * 0.05 / (DRAWS * parameters / 2))


def white_deviation(system, estimate):
    """What least squares claims if noise were white, by inverse(W^T W / sigma^2)."""
    rows = (system.regressor / estimate.noise[:, None]).reshape(-1, len(estimate.values))
    return np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))


def test_intervals_hold_the_truth():
    exact, truth = equations(rows=800)
    exact = replace(exact, weight=np.where(np.abs(exact.regressor[:, :, 6:8].sum(axis=2)) > 0.1, 1.0, 0.0))
    assert 0.01 < np.mean(exact.weight == 0) < 0.2  # some rows stick
    errors, deviations, naive = [], [], []
    for system in draws(exact):
        estimate = weighted(system)
        errors.append(estimate.values - truth)
        deviations.append(estimate.std)
        naive.append(white_deviation(system, estimate))
    share = held(np.array(errors), np.array(deviations))
    assert abs(share - 0.95) < tolerance(len(truth)) + 0.005, share  # half a per cent: the noise is estimated
    assert held(np.array(errors), np.array(naive)) < 0.85
    # the deviations are those of the scatter, one parameter at a time: 100 draws give it to 7 %
    np.testing.assert_allclose(np.mean(deviations, axis=0), np.std(errors, axis=0), rtol=0.2)


def test_gains_and_values_together():
    exact, truth = equations(rows=800, payload=True)
    errors, deviations = [], []
    for system in draws(exact):
        estimate = maximum_likelihood(replace(system, gain=0.9 * GAIN))
        errors.append(np.concatenate([estimate.values - truth, estimate.gain - GAIN]))
        deviations.append(np.concatenate([estimate.std, estimate.gain_std]))
    share = held(np.array(errors), np.array(deviations))
    assert abs(share - 0.95) < tolerance(len(truth) + 2) + 0.005, share
    assert np.all(np.abs(np.mean(errors, axis=0)) < 4 * np.std(errors, axis=0) / np.sqrt(DRAWS))


@pytest.mark.parametrize("estimator", [weighted, consistent])
def test_nominal_gains_are_as_wrong_as_stated(estimator):
    """True gains are drawn and nominal ones fitted, whose tolerance is in the intervals."""
    exact, truth = equations(rows=600, gain_tolerance=0.1)
    random = np.random.default_rng(3)
    errors, deviations, given = [], [], []
    for _ in range(DRAWS):
        true = GAIN * (1.0 + 0.1 * random.normal(size=2))
        noise = np.concatenate([coloured(rows.stop - rows.start, random) for rows in exact.runs])
        estimate = estimator(replace(exact, current=exact.current * GAIN / true + noise))
        errors.append(estimate.values - truth)
        deviations.append(estimate.std)
        given.append(np.sqrt(np.diag(given_nominal(estimate))))
    share = held(np.array(errors), np.array(deviations))
    # all parameters of a joint are wrong with its gain: two draws in a repetition, not one a parameter
    assert abs(share - 0.95) < 3 * np.sqrt(0.95 * 0.05 / (DRAWS * 2)) + 0.005, share
    assert held(np.array(errors), np.array(given)) < 0.7


def test_what_the_model_lacks_is_in_the_intervals():
    """Noise that grows with speed is not alike throughout; viscous friction is known half as well for it."""
    exact, truth = equations(rows=1200)
    place = exact.names.index("Fv1")
    speed = np.abs(exact.regressor[:, 0, place])
    level = np.stack([np.minimum((speed / np.std(speed)) ** 2, 20.0), np.ones(len(speed))], axis=1)
    random, errors, deviations = np.random.default_rng(5), [], []
    for _ in range(100):
        noise = np.concatenate([coloured(rows.stop - rows.start, random) for rows in exact.runs])
        estimate = weighted(replace(exact, current=exact.current + level * noise))
        errors.append(estimate.values - truth)
        deviations.append(estimate.std)
    share = held(np.array(errors), np.array(deviations))
    assert abs(share - 0.95) < 0.025, share
    # one autocovariance for the whole run states 0.47 of it
    assert 0.8 < np.mean(deviations, axis=0)[place] / np.std(errors, axis=0)[place] < 1.2
