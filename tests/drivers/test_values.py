"""What a telegram may hold, and where a joint stands: known only where several measurements agree."""

import math

import numpy as np
import pytest

from exidyn.drivers import Sample
from exidyn.drivers.errors import Unreadable
from exidyn.drivers.values import AGREEING, APART, LATEST, RANGES, SIGNALS, Resting, checked, nanoseconds


def sample(host_time=10**18, controller_time=0, **signals):
    values = {name: np.full(3, 1.0) for name in SIGNALS} | signals
    return Sample(host_time, controller_time, **values)


@pytest.mark.parametrize("name", SIGNALS)
@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e300, -1e300])
def test_a_value_that_no_joint_can_have_is_not_received_and_named(name, value):
    seen = checked(sample(**{name: np.array([1.0, value, 1.0])}))
    assert np.array_equal(getattr(seen, name), [1.0, np.nan, 1.0], equal_nan=True)
    assert f"{name} of joint 2 is" in seen.events[0]
    assert RANGES[name][2] in seen.events[0]


def test_what_can_be_passes_as_it_is():
    silent = sample(position=np.array([0.0, np.nan, -50.0]), temperature=np.full(3, np.nan))
    assert checked(silent) is silent


@pytest.mark.parametrize(
    "wrong", [{"host_time": -1}, {"controller_time": 1 << 63}, {"position": np.zeros(2)}]
)
def test_times_and_shapes_that_cannot_be_are_unreadable(wrong):
    with pytest.raises(Unreadable):
        checked(sample(**wrong))


@pytest.mark.parametrize("seconds", [float("nan"), float("inf"), -5.0, 1e30, 2.0 * LATEST])
def test_a_time_that_no_controller_shows_is_unreadable(seconds):
    with pytest.raises(Unreadable, match="timestamp is"):
        nanoseconds("timestamp", seconds)
    assert nanoseconds("timestamp", 1.5) == 1_500_000_000


def test_it_is_known_after_enough_measurements_that_agree():
    resting = Resting(2)
    for number in range(AGREEING):
        assert not resting.known(1)
        resting.add(1, 1.0 + 1e-4 * number)
    assert resting.known(1)
    assert not resting.known(0)
    assert resting.position(1) == 1.0 + 1e-4 * (AGREEING // 2)


def test_one_that_is_wrong_or_missing_delays_it():
    resting = Resting(1)
    for position in [0.0] * (AGREEING - 1) + [2.0 * APART] + [0.0] * (AGREEING - 1):
        resting.add(0, position)
        assert not resting.known(0)
    resting.add(0, 0.0)
    assert resting.known(0)
    resting.add(0, math.nan)
    assert not resting.known(0)
    assert resting.spread(0) == 0.0
