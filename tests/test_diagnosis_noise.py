"""Noise of a diagnosis: whitening across gaps, colour beside a hypothesis, lines in spectra."""

from types import SimpleNamespace

import numpy as np
import pytest
from exidyn.identify.diagnosis.candidate import Candidate, Thinned
from exidyn.identify.diagnosis.hypothesis import weighed
from exidyn.identify.diagnosis.recolouring import recoloured
from exidyn.identify.diagnosis.remainder import line
from exidyn.identify.diagnosis.rows import Rows
from exidyn.identify.diagnosis.solving import solved
from exidyn.identify.diagnosis.whitening import Whitening, autocovariance
from scipy import signal, stats

RUNS = (slice(0, 700), slice(700, 1500))


def coloured(rng, count, filter_=(1.0, -0.9), scale=0.3):
    return signal.lfilter([scale], filter_, rng.normal(size=count + 300))[300:]


def torn(rng, count, gaps=25):
    weight = np.ones((count, 1))
    for start in rng.integers(0, count, gaps):
        weight[start : start + rng.integers(1, 40)] = 0.0
    return weight


def test_probability_of_rows_with_gaps_is_that_of_their_covariance():
    rng = np.random.default_rng(4)
    residual, weight = coloured(rng, 400), torn(rng, 400, 8)
    whitening = Whitening.of(residual[:, None], weight, (slice(0, 400),), order=1)
    counts = weight[:, 0] > 0
    covariance = autocovariance(whitening.filters[0], float(whitening.scale[0]))
    lags = np.abs(np.subtract.outer(np.flatnonzero(counts), np.flatnonzero(counts)))
    exact = stats.multivariate_normal.logpdf(residual[counts], cov=covariance[lags])
    white = whitening.apply(0, residual)
    found = stats.norm.logpdf(white).sum() - whitening.logarithm(0)
    assert len(white) == counts.sum()
    assert found == pytest.approx(exact, abs=1.0)  # the covariance has a white part, the filter has not


def test_white_rows_are_white_after_gaps_too():
    rng = np.random.default_rng(5)
    residual, weight = coloured(rng, 1500, (1.0, -1.5, 0.7)), torn(rng, 1500)
    whitening = Whitening.of(residual[:, None], weight, RUNS)
    whole = np.zeros(1500)
    whole[weight[:, 0] > 0] = whitening.apply(0, residual)
    after = whole[whitening.gaps[0].rows]
    assert len(after) > 100
    assert np.std(whole[weight[:, 0] > 0]) == pytest.approx(1.0, abs=0.05)
    assert np.std(after) == pytest.approx(1.0, abs=0.25)


def rows_with(torque, rng):
    difference = (torque + coloured(rng, 1500, (1.0, -0.5), 0.1))[:, None]
    ones = np.ones((1500, 1))
    return Rows(RUNS, difference, ones, ones[:, :, None], ("offset",), np.array([np.inf]), np.zeros(1))


def asked(column):
    candidate = Candidate("slow", (0,), lambda run: column, ("size",), ("N m",), (-np.inf,))
    return candidate, Thinned(np.array([0]), column[:, None, None], np.array([1.0]), np.zeros(1))


def test_slow_effect_is_not_whitened_away_with_the_noise():
    rng = np.random.default_rng(6)
    slow = np.sin(2 * np.pi * np.arange(1500) / 1100)
    solution = solved(rows_with(0.3 * slow, rng))
    plain = weighed(solution, *asked(slow))
    own, whitening = recoloured(solution, plain)
    assert own.evidence > 2 * plain.evidence > 0
    assert own.values[0] == pytest.approx(0.3, abs=0.02)
    assert whitening.filters[0, 1] == pytest.approx(-0.5, abs=0.08)


def test_recolouring_gives_nothing_to_what_is_not_there():
    rng = np.random.default_rng(7)
    solution = solved(rows_with(np.zeros(1500), rng))
    evidence = []
    for period in (60, 130, 400, 900, 1400):
        own, _ = recoloured(solution, weighed(solution, *asked(np.cos(2 * np.pi * np.arange(1500) / period))))
        evidence.append(own.evidence)
    assert max(evidence) < 3.0


def left(amplitude, rng, lined=(0, 1)):
    parts = [rng.normal(size=800) for _ in range(3)]
    for run in lined:
        parts[run] = parts[run] + amplitude * np.sin(2 * np.pi * 0.117 * np.arange(800) + run)
    whole = np.concatenate(parts)
    runs = tuple(slice(800 * k, 800 * (k + 1)) for k in range(3))
    whitening = SimpleNamespace(valid=np.ones((2400, 1), bool))
    return SimpleNamespace(whitening=whitening, rows=SimpleNamespace(runs=runs), residual=whole[:, None])


def test_line_is_found_where_two_runs_have_it():
    assert line(left(0.6, np.random.default_rng(8)), 0, 100.0) == pytest.approx(11.7, abs=0.2)


@pytest.mark.parametrize("seed", range(8))
def test_no_line_in_noise_or_in_one_run_alone(seed):
    rng = np.random.default_rng(seed)
    assert line(left(0.0, rng), 0, 100.0) == 0.0
    assert line(left(0.6, rng, lined=(1,)), 0, 100.0) == 0.0
