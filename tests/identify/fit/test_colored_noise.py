import numpy as np
import pytest
from scipy import signal

from exidyn.identification.fit.estimators.colored_noise import autocovariance, shrunk, spectrum

from ...parts.small.two_joints import MIX, POLES, colour_covariance, coloured

pytestmark = pytest.mark.numerical


def exact_autocovariance(lags):
    """Of `coloured`, from its definition: Gamma(k) = POLES^k Gamma(0)."""
    return np.stack([np.linalg.matrix_power(POLES, k) @ colour_covariance() for k in range(lags + 1)])


def test_autocovariance_and_spectrum_of_a_known_process():
    process = coloured(200_000, np.random.default_rng(0))
    found = autocovariance([process], [np.ones_like(process)], 3)
    size = np.sqrt(np.diag(colour_covariance()))
    # two hundred thousand rows remembered for some five: 0.5 per cent
    np.testing.assert_allclose(
        found / np.outer(size, size), exact_autocovariance(3) / np.outer(size, size), atol=0.02
    )
    assert abs(found[1][0, 1] - found[1][1, 0]) > 0.1 * abs(found[1][0, 1])  # the sign of the lag
    density = spectrum(exact_autocovariance(20), 512)
    np.testing.assert_allclose(density.mean(axis=0), colour_covariance(), rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(density, density.conj().transpose(0, 2, 1), atol=1e-12 * np.abs(density).max())
    # (1 - POLES z)^-1 MIX MIX^T (1 - POLES z)^-H.
    density = spectrum(exact_autocovariance(400), 1024)
    turn = np.exp(-2j * np.pi * np.arange(1024) / 1024)
    transfer = np.linalg.inv(np.eye(2) - POLES * turn[:, None, None])
    exact = transfer @ (MIX @ MIX.T) @ transfer.conj().transpose(0, 2, 1)
    np.testing.assert_allclose(density, exact, atol=0.01 * np.abs(exact).max())


def test_autocovariance_by_hand_with_weights_and_pieces():
    random = np.random.default_rng(1)
    pieces = [random.normal(size=(7, 2)), random.normal(size=(4, 2)), random.normal(size=(1, 2))]
    weights = [(random.uniform(size=p.shape) > 0.3).astype(float) for p in pieces]
    found = autocovariance(pieces, weights, 2)
    counts = sum(w.sum(axis=0) for w in weights)
    for lag in range(3):
        for i in range(2):
            for j in range(2):
                total = sum(
                    p[k, i] * w[k, i] * p[k - lag, j] * w[k - lag, j]
                    for p, w in zip(pieces, weights, strict=True)
                    for k in range(lag, len(p))
                )
                assert found[lag, i, j] == pytest.approx(total / np.sqrt(counts[i] * counts[j]), abs=1e-14)


def test_spectrum_is_positive_whatever_the_gaps():
    """Narrow-band noise with holes: lag-by-lag means would make a spectrum that is negative somewhere."""
    random = np.random.default_rng(2)
    noise = signal.lfilter(*signal.butter(6, 0.3), random.normal(size=(400, 2)), axis=0)
    weight = (random.uniform(size=(400, 2)) > 0.3).astype(float)
    density = spectrum(autocovariance([noise], [weight], 30), 256)
    sizes = np.linalg.eigvalsh(density)
    assert sizes.min() > -1e-12 * sizes.max()


def estimated(noise, lags=80):
    return autocovariance([noise], [np.ones_like(noise)], lags)


def test_independent_joints_seem_correlated_and_are_made_independent():
    """Thirty seconds of seven joints at 40 Hz: the least noisy combination seems to have half its noise."""
    noise = np.random.default_rng(3).normal(size=(1200, 7))
    found = estimated(noise)
    smallest = np.linalg.eigvalsh(spectrum(found, 256)).min(axis=1).mean()
    assert smallest < 0.6
    after = shrunk(found, 1200)
    np.testing.assert_array_equal(np.diagonal(after, axis1=1, axis2=2), np.diagonal(found, axis1=1, axis2=2))
    between = ~np.eye(7, dtype=bool)
    assert np.linalg.norm(after[:, between]) < 0.2 * np.linalg.norm(found[:, between])


def test_joints_are_as_correlated_as_they_are():
    process = coloured(20_000, np.random.default_rng(4))
    found = estimated(process)
    after = shrunk(found, 20_000)
    np.testing.assert_allclose(after[0], found[0], rtol=0.02)
    assert abs(after[0][0, 1]) > 0.1 * np.sqrt(after[0][0, 0] * after[0][1, 1])
    noise = np.random.default_rng(5).normal(size=(400, 3)) * [1.0, 0.0, 1.0]
    assert np.all(np.isfinite(shrunk(estimated(noise), 400)))
    assert np.all(shrunk(estimated(noise[:, :1]), 400) == estimated(noise[:, :1]))
