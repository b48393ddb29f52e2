"""Where a joint stands is known only where several measurements agree."""

import math

from exidyn.drivers.values import AGREEING, APART, Resting


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
