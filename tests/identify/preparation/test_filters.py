import numpy as np
import pytest

from exidyn.identification.arm.motion import differentiate
from exidyn.identification.preparation.filters import Decimation, low_pass, uniform

pytestmark = pytest.mark.numerical

RATE = 500.0


def wave(frequency, rate=RATE, seconds=4.0):
    time = np.arange(int(seconds * rate)) / rate
    angle = 2 * np.pi * frequency
    columns = np.stack([np.sin(angle * time), np.cos(angle * time)], axis=1)
    first = angle * np.stack([columns[:, 1], -columns[:, 0]], axis=1)
    return time, columns, first, -(angle**2) * columns


@pytest.mark.parametrize("frequency", [0.5, 3.0, 10.0])
def test_derivatives_of_a_sine(frequency):
    _, values, first, second = wave(frequency)
    velocity, acceleration = differentiate(values, RATE)
    angle = 2 * np.pi * frequency
    # truncation by (angle / rate)^6 / 140, and rounding times the rate squared
    np.testing.assert_allclose(velocity[3:-3], first[3:-3], atol=angle * ((angle / RATE) ** 6 / 100 + 1e-11))
    np.testing.assert_allclose(acceleration[3:-3], second[3:-3], atol=angle**2 * (angle / RATE) ** 6 + 1e-9)


def test_derivatives_of_a_polynomial_are_exact_also_near_the_ends():
    time = np.linspace(-1, 1, 41)
    powers = np.arange(2, 7)
    velocity, acceleration = differentiate(time[:, None] ** powers, 20.0)
    first, second = (
        powers * time[:, None] ** (powers - 1),
        powers * (powers - 1) * time[:, None] ** (powers - 2),
    )
    np.testing.assert_allclose(velocity[3:-3], first[3:-3], atol=1e-12)
    np.testing.assert_allclose(acceleration[3:-3], second[3:-3], atol=1e-10)


def test_sixth_order_is_as_accurate_at_a_twelfth_of_the_rate_as_stated():
    _, values, first, second = wave(RATE / 12)
    velocity, acceleration = differentiate(values, RATE)
    short = 1 - np.linalg.norm(velocity[3:-3]) / np.linalg.norm(first[3:-3])
    assert 1e-5 < short < 2e-4
    three_point = 1 - np.linalg.norm(np.gradient(values, 1 / RATE, axis=0)[3:-3]) / np.linalg.norm(
        first[3:-3]
    )
    assert three_point == pytest.approx(0.045, abs=0.005)
    assert abs(1 - np.linalg.norm(acceleration[3:-3]) / np.linalg.norm(second[3:-3])) < 1e-4


def test_low_pass_keeps_slow_and_constant_and_phase():
    time, values, _, _ = wave(2.0)
    filtered = low_pass(values + 3.0, RATE, 20.0)
    inner = slice(200, -200)
    np.testing.assert_allclose(filtered[inner], values[inner] + 3.0, atol=1e-6)
    # -3 dB twice, forward and backward, at the cut-off
    _, edge, _, _ = wave(20.0)
    share = low_pass(edge, RATE, 20.0)[inner] / 0.5
    np.testing.assert_allclose(share, edge[inner], atol=0.01)


@pytest.mark.parametrize(("rate", "cutoff"), [(500.0, 20.0), (500.0, 7.3), (100.0, 30.0), (100.0, 60.0)])
def test_decimation_is_a_convolution_sampled_at_its_centres(rate, cutoff):
    decimation = Decimation.at(rate, cutoff)
    values = np.random.default_rng(1).normal(size=(1203, 2, 3))
    filtered = np.apply_along_axis(lambda v: np.convolve(v, decimation.taps, "same"), 0, values)
    out = decimation.apply(values)
    assert out.shape == (len(decimation.centres(1203)), 2, 3)
    np.testing.assert_allclose(out, filtered[decimation.centres(1203)], atol=1e-13)


def test_decimation_in_pieces_is_decimation_of_the_whole():
    decimation = Decimation.at(500.0, 20.0)
    values = np.random.default_rng(2).normal(size=(2000, 4))
    whole = decimation.apply(values)
    pieces = [
        decimation.apply(values[k * decimation.factor : (k + 6) * decimation.factor + len(decimation.taps)])[
            :7
        ]
        for k in range(0, len(whole), 7)
    ]
    np.testing.assert_allclose(np.concatenate(pieces)[: len(whole)], whole, atol=1e-13)


@pytest.mark.parametrize("piece", [1, 13, 400, 5000])
@pytest.mark.parametrize("cutoff", [20.0, 300.0])
def test_a_stream_of_pieces_is_the_whole(piece, cutoff):
    decimation = Decimation.at(500.0, cutoff)
    values = np.random.default_rng(3).normal(size=(1501, 2, 3))
    pieces = (values[start : start + piece] for start in range(0, len(values), piece))
    np.testing.assert_allclose(decimation.stream(pieces), decimation.apply(values), atol=1e-13)


def test_every_other_sample_of_a_slow_signal_gives_the_same():
    """The filter on a thinned signal: same centres, same values, as long as the signal has no more in it."""
    whole = Decimation.at(500.0, 5.0)
    random = np.random.default_rng(4)
    slow = low_pass(random.normal(size=(3003, 3)), 500.0, 8.0)
    expected = whole.apply(slow)
    for rate in (500.0, 200.0, 90.0, 40.0):
        thin = whole.thinned(rate)
        assert 500.0 / thin.step >= rate
        assert whole.factor % thin.step == 0
        found = thin.apply(slow[:: thin.step])[: len(expected)]
        assert found.shape == expected.shape
        np.testing.assert_allclose(found, expected, atol=1e-3 * np.abs(expected).max())
        centres = thin.centres(len(slow[:: thin.step]))[: len(expected)] * thin.step
        np.testing.assert_array_equal(centres, whole.centres(len(slow)))


def test_decimation_has_unit_gain_half_at_the_cutoff_and_no_phase():
    decimation = Decimation.at(500.0, 20.0)
    assert decimation.taps.sum() == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(decimation.taps, decimation.taps[::-1], atol=1e-16)
    for frequency, gain in ((0.0, 1.0), (10.0, 1.0), (20.0, 0.5), (0.5 * decimation.output_rate, 0.0)):
        time, values, _, _ = wave(frequency)
        expected = gain * values[decimation.centres(len(time))]
        np.testing.assert_allclose(decimation.apply(values), expected, atol=4e-3)  # Hamming's ripple


def test_a_run_shorter_than_the_filter_gives_no_rows():
    decimation = Decimation.at(500.0, 20.0)
    assert decimation.apply(np.ones((len(decimation.taps) - 1, 2))).shape == (0, 2)
    np.testing.assert_allclose(decimation.apply(np.ones((len(decimation.taps), 2))), [[1.0, 1.0]])


def test_a_column_that_was_not_measured_spoils_no_other():
    values = np.ones((1000, 2))
    values[:, 1] = np.nan
    out = Decimation.at(500.0, 20.0).apply(values)
    np.testing.assert_allclose(out[:, 0], 1.0)
    assert np.isnan(out[:, 1]).all()


def test_irregular_stamps_and_another_rate_are_resampled():
    random = np.random.default_rng(4)
    stamps = np.cumsum(random.uniform(0.001, 0.003, 2000))
    even, values = uniform(stamps, np.sin(2 * np.pi * stamps)[:, None], RATE)
    np.testing.assert_allclose(np.diff(even), 1 / RATE, rtol=1e-9)
    assert even[0] == stamps[0]
    assert stamps[-1] - 1 / RATE < even[-1] <= stamps[-1] + 1e-9
    np.testing.assert_allclose(values[:, 0], np.sin(2 * np.pi * even), atol=1e-8)
    time = np.arange(1001) / 1000.0
    even, values = uniform(time, np.cos(6 * time)[:, None], 250.0)
    assert len(even) == 251
    np.testing.assert_allclose(values[:, 0], np.cos(6 * even), atol=1e-9)


def test_samples_whose_stamps_nearly_coincide_count_as_one():
    """Messages that arrive late come right before the next; a curve through both would run far astray."""
    time = np.arange(2000) / RATE
    stamps = time.copy()
    stamps[100::40] = time[101::40] - 2e-6
    values = np.sin(2 * np.pi * time)[:, None]
    values = values + 1e-3 * np.random.default_rng(4).normal(size=values.shape)
    even, smooth = uniform(stamps, values, RATE)
    # A stamp that is a sample late moves the position by the velocity times half of that.
    np.testing.assert_allclose(smooth[:, 0], np.sin(2 * np.pi * even), atol=2e-2)
