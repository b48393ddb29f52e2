"""Every fault in every stage: what is asked of the driver, and when. The arm follows its drives' commands at
once; `benchmarks/record.py --only escalation` has the same table with an arm that has mass."""

from itertools import product

import numpy as np
import pytest
from parts.record.escalation.arm import light
from parts.record.escalation.cases import CASES
from parts.record.escalation.run import ran
from parts.record.escalation.table import wrong

from exidyn.acquire.run.frames import STAGES
from exidyn.acquire.run.stopping.escalation import (
    RULES,
    WATCHED,
    Sight,
    Sign,
    State,
    allowed_speed,
    escalate,
    overdue,
    state_of,
)
from exidyn.acquire.run.stopping.stop import Stop, Stops, after_failure
from exidyn.drivers import StopLevel

pytestmark = pytest.mark.clocked

NONE, BRAKE, QUICK, OFF = 0, *StopLevel
LEVEL = {State.QUICK: QUICK, State.OFF: OFF}


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.fault.name}, {case.stage}")
def test_what_is_asked_of_the_driver(case):
    seen = ran(case, light)
    assert not wrong(case, seen)
    assert seen.asked == sorted(set(seen.asked))


def sight(seconds):
    return Sight("joint1", 2.0, 1.0, seconds)


@pytest.mark.parametrize(("state", "sign"), list(product(State, Sign)))
def test_a_sign_does_what_the_table_states_after_its_time_and_nothing_before(state, sign):
    rule = RULES.get((state, sign))
    for seconds in (0.0, 0.099, 0.101, 0.199, 0.201, 10.0):
        found = escalate(state, {sign: sight(seconds)})
        if rule is None or seconds < rule.seconds:
            assert found is None
        else:
            assert (found.level, found.kind, found.value, found.limit) == (rule.level, sign.value, 2.0, 1.0)
    assert (rule is not None) == (sign in WATCHED[state])


def test_the_table_goes_up_one_level_at_a_time_and_takes_the_torque_only_after_a_quick_stop():
    for (state, _), rule in RULES.items():
        assert rule.level > LEVEL.get(state, NONE)
        assert (rule.level == OFF) == (state is State.QUICK)
    assert not WATCHED[State.OFF]
    assert not WATCHED[State.MOVING]


@pytest.mark.parametrize("stage", range(len(STAGES)))
def test_a_state_is_that_of_the_commands_until_the_controller_stops(stage):
    expected = {"approaching": State.MOVING, "running": State.MOVING}
    expected |= {name: State[name.upper()] for name in ("listening", "braking", "holding")}
    for level in (NONE, BRAKE):
        assert state_of(level, stage) is expected[STAGES[stage]]
    assert state_of(QUICK, stage) is State.QUICK
    assert state_of(OFF, stage) is State.OFF


class Refusing:
    """A driver that fails at some levels."""

    def __init__(self, *levels):
        self.levels, self.asked = levels, []

    def stop(self, level):
        self.asked.append(level)
        if level in self.levels:
            raise OSError("no such device")


@pytest.mark.parametrize("begin", list(StopLevel))
@pytest.mark.parametrize("then", list(StopLevel))
@pytest.mark.parametrize("fails", [(), (QUICK,), (OFF,), (QUICK, OFF)])
def test_no_level_goes_down_or_is_asked_twice_and_a_failure_asks_for_the_next(begin, then, fails):
    driver, events = Refusing(*fails), []
    stops = Stops(driver, lambda *event: events.append(event))
    first = Stop(begin, "first", "")
    stops.begin(first)
    stops.begin(Stop(then, "then", ""))
    stops.escalate(Stop(then, "then", ""))
    assert driver.asked == sorted(set(driver.asked))
    highest = max(begin, then)
    expected = OFF if QUICK in fails and highest == QUICK else highest
    assert stops.level == expected
    levels = [details["level"] for kind, _, details in events if kind == "stop"]
    assert levels == sorted(set(levels), key=lambda name: StopLevel[name])
    assert any("no such device" in text for _, text, _ in events) == any(f in driver.asked for f in fails)


def test_behind_off_nothing_is_left():
    assert after_failure(OFF, OSError()) is None
    assert after_failure(QUICK, OSError("why")).level == OFF
    assert "why" in after_failure(QUICK, OSError("why")).text


def test_a_quick_stop_worked_out_by_hand():
    """2 rad/s with half of 4 rad/s^2, from 0.15 s on: 1 rad/s at 0.65 s, rest at 1.15 s."""
    speed, limit = np.array([2.0, 0.0]), np.array([4.0, 4.0])
    np.testing.assert_allclose(allowed_speed(speed, limit, 0.1), speed)
    np.testing.assert_allclose(allowed_speed(speed, limit, 0.65), [1.0, 0.0])
    np.testing.assert_allclose(allowed_speed(speed, limit, 3.0), 0.0)
    assert overdue(speed, limit, 0.14).tolist() == [False, False]
    assert overdue(speed, limit, 1.14).tolist() == [False, True]
    assert overdue(speed, limit, 1.16).tolist() == [True, True]
    assert overdue(10 * speed, limit, 1.16).tolist() == [True, True]  # but it may still be that fast
