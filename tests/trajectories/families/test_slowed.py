import numpy as np
import pytest

from exidyn.trajectories.errors import BadLimits
from exidyn.trajectories.families.sequence import Slowed

from ...parts.runs.run_parts import motion


def test_the_path_is_the_same_and_every_rate_smaller_by_its_power():
    full, half = motion(), Slowed(motion(), 0.5)
    time = np.linspace(0.0, half.duration, 501)
    fast, slow = full.at(0.5 * time), half.at(time)
    assert half.duration == 2 * full.duration
    for order, name in enumerate(("position", "velocity", "acceleration", "jerk")):
        assert np.allclose(getattr(slow, name), 0.5**order * getattr(fast, name))


def test_velocity_is_the_slope_of_position():
    slow = Slowed(motion(), 0.3)
    time = np.linspace(0.01, slow.duration - 0.01, 200)
    slope = (slow.at(time + 1e-6).position - slow.at(time - 1e-6).position) / 2e-6
    assert np.allclose(slope, slow.at(time).velocity, atol=1e-6)


def test_extremes_are_those_of_the_samples():
    slow = Slowed(motion(), 0.3)
    states, extremes = slow.every(1e-4), slow.extremes()
    assert np.allclose(extremes.velocity.upper, states.velocity.max(axis=0), rtol=1e-3)
    row = np.argmax(states.velocity[:, 0])
    assert np.isclose(
        slow.state_at(extremes.velocity.upper_time[0]).velocity[0], states.velocity[row, 0], rtol=1e-3
    )


@pytest.mark.parametrize("speed", [0.0, -0.1, 1.1, np.nan])
def test_a_speed_that_is_none_is_refused(speed):
    with pytest.raises(BadLimits, match="at most 1"):
        Slowed(motion(), speed)
