import numpy as np
import pytest

from exidyn.identification.arm.robot import Limits
from exidyn.trajectories.random_motion import RampedFourier, random_fourier

from ..parts.small.two_joints import arm

SERIES = RampedFourier(
    period=4.0,
    centre=np.array([0.2, -0.4]),
    sine=np.array([[0.5, -0.1, 0.05], [0.1, 0.3, -0.2]]),
    cosine=np.array([[-0.2, 0.15, 0.1], [0.4, 0.0, 0.02]]),
    duration=12.0,
    ramp=1.5,
    rest=0.5,
)


def test_derivatives_are_those_of_the_position():
    step, time = 1e-4, np.linspace(0.01, 11.99, 997)
    before, here, after = (SERIES.at(time + shift) for shift in (-step, 0.0, step))
    np.testing.assert_allclose((after.position - before.position) / (2 * step), here.velocity, atol=1e-6)
    np.testing.assert_allclose((after.velocity - before.velocity) / (2 * step), here.acceleration, atol=2e-5)


def test_it_is_the_series_once_up_to_speed():
    """Between the ramps the phase is time minus half a ramp and the rest."""
    time = np.linspace(2.1, 9.9, 50)
    angle = 2 * np.pi / 4.0 * np.outer(time - 0.5 - 0.75, [1, 2, 3])
    expected = SERIES.centre + np.sin(angle) @ SERIES.sine.T + np.cos(angle) @ SERIES.cosine.T
    np.testing.assert_allclose(SERIES.at(time).position, expected, atol=1e-12)


def test_it_rests_at_both_ends_and_begins_without_a_jump():
    for time in (np.linspace(-1.0, 0.5, 20), np.linspace(11.5, 13.0, 20)):
        motion = SERIES.at(time)
        assert not np.any([motion.velocity, motion.acceleration])
        np.testing.assert_array_equal(motion.position, np.tile(motion.position[0], (20, 1)))
    motion = SERIES.at(np.linspace(0.0, 12.0, 120_001))
    assert np.abs(np.diff(motion.acceleration, axis=0)).max() < 0.01


@pytest.mark.parametrize("seed", range(2))
def test_random_motion_keeps_nine_tenths_of_the_limits_and_uses_one_fully(seed):
    limits = arm().limits
    motion = random_fourier(limits, 30.0, seed=seed).at(np.linspace(0.0, 30.0, 30_001))
    middle = 0.5 * (limits.position_lower + limits.position_upper)
    used = np.stack(
        [
            np.abs(motion.position - middle).max(axis=0) / (limits.position_upper - middle),
            np.abs(motion.velocity).max(axis=0) / limits.velocity,
            np.abs(motion.acceleration).max(axis=0) / limits.acceleration,
        ]
    )
    np.testing.assert_allclose(used.max(axis=0), 0.9, rtol=0.002)


def test_an_arm_without_limits_turns_at_most_half_a_turn_each_way():
    motion = random_fourier(Limits.none(3), 20.0).at(np.linspace(0.0, 20.0, 2001))
    np.testing.assert_allclose(np.abs(motion.position).max(axis=0), 0.9 * np.pi, rtol=0.002)
