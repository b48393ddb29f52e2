import numpy as np
import pytest
from scipy import signal

from exidyn.identification.preparation.spectra import (
    LOWEST,
    accelerations,
    motion_band,
    noise_crossing,
    noise_spectra,
    nominal_inertia,
    position_cutoff,
)

from ...parts.small.two_joints import GAIN, model

pytestmark = pytest.mark.numerical

RATE = 500.0


def sines(*frequencies, seconds=40.0, amplitude=0.3):
    """Position of two joints: sines whose accelerations are equally strong."""
    time = np.arange(int(seconds * RATE)) / RATE
    waves = sum(np.sin(2 * np.pi * f * time + f) * (frequencies[0] / f) ** 2 for f in frequencies)
    return amplitude * np.stack([waves, 0.5 * waves], axis=1)


def noise(size, like, seed=0):
    return size * np.random.default_rng(seed).normal(size=like.shape)


def test_spectra_are_those_of_known_noise():
    white = noise(0.2, np.zeros((50_000, 2)))
    frequency, density, floor = noise_spectra(white, RATE)
    assert np.trapezoid(density[:, 0], frequency) == pytest.approx(0.04, rel=0.03)
    np.testing.assert_allclose(floor, 0.04 / (0.5 * RATE), rtol=0.05)
    still = sines(0.2, 0.4)
    _, _, floor = noise_spectra(still + noise(1e-6, still), RATE)
    np.testing.assert_allclose(floor, 1e-12 / (0.5 * RATE), rtol=0.1)
    still = sines(4.0)
    frequency, density, _ = accelerations(still, RATE)
    power = np.trapezoid(density, frequency, axis=0)
    expected = 0.5 * (np.array([0.3, 0.15]) * (8 * np.pi) ** 2) ** 2
    np.testing.assert_allclose(power, expected, rtol=0.02)


def test_less_encoder_noise_lets_higher_frequencies_pass():
    """Band-limited motion: a spectrum falling by 60 dB a decade above 3 Hz meets the noise later."""
    random = np.random.default_rng(1)
    frequency = np.fft.rfftfreq(20_000, 1 / RATE)
    rough = np.fft.irfft(
        np.fft.rfft(random.normal(size=(20_000, 2)), axis=0) / (1 + (frequency / 3) ** 3)[:, None], axis=0
    )
    cutoffs = [position_cutoff(rough + noise(size, rough), RATE) for size in (1e-2, 1e-3, 1e-4)]
    assert 1.5 * LOWEST <= cutoffs[0] < cutoffs[1] < cutoffs[2] < 0.36 * RATE
    # white unit noise over (f / 3)^3 in amplitude sinks under noise of that size at 3 / size^(1/3)
    np.testing.assert_allclose(cutoffs[:2], [3 / 1e-2 ** (1 / 3), 3 / 1e-3 ** (1 / 3)], rtol=0.3)


def test_noise_is_not_taken_for_motion():
    # Jitter of stamps, or a controller's filter: the top of the spectrum is quieter than the noise is.
    moved = sines(0.2, 0.4)
    coloured = signal.sosfiltfilt(
        signal.butter(1, 0.25 * RATE, fs=RATE, output="sos"), noise(1e-5, moved), axis=0
    )
    # twice differentiated, noise of 1e-5 rad passes 1 % of the motion's acceleration below 10 Hz
    assert position_cutoff(moved + coloured, RATE) < 15.0
    only = noise(1e-4, np.zeros((20_000, 2)))
    assert position_cutoff(only, RATE) == 1.5 * LOWEST
    for highest in (1.0, 2.5, 6.0):
        moved = sines(0.2, highest / 4, highest / 2, highest)
        assert highest < motion_band(moved + noise(1e-8, moved), RATE) <= highest + 1.5


def test_inertia_is_the_mass_matrix():
    import pinocchio as pin

    of = model()
    posture = np.array([0.3, -1.1])
    exact = pin.crba(of.robot.kinematics, of.robot.kinematics.createData(), posture)
    exact = np.triu(exact) + np.triu(exact, 1).T
    np.testing.assert_allclose(nominal_inertia(of, posture), exact, rtol=1e-12)


def test_crossing_is_where_encoder_noise_would_exceed_the_current():
    moved = sines(0.2, 0.5)
    encoder, current = 1e-5, 0.05
    found = noise_crossing(model(), moved + noise(encoder, moved), noise(current, moved, 1), GAIN, RATE)
    inertia = nominal_inertia(model(), moved.mean(axis=0))
    amplification = np.sqrt((inertia**2).sum(axis=1)) * encoder / (np.abs(GAIN) * current)
    expected = 0.7 / (2 * np.pi * np.sqrt(amplification.max()))
    assert found == pytest.approx(expected, rel=0.05)
    # and there, summed up to it, the encoder adds at most five per cent to the noise
    assert 0.7**4 / 5 < 0.05
