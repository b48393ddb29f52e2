"""The Feetech driver, against servos that run as a process."""

import numpy as np
import pytest

from exidyn.drivers.feetech.driver import GOAL_VELOCITY

from ...parts.controllers.servo_parts import (
    TURN,
    armed,
    counting,
    driver,
    fresh,
    hold,
    send_only,
    servo,
    until,
)


@pytest.fixture
def kind():
    return "feetech"


def test_servos_are_found_and_nobody_claims_that_they_stop_by_themselves(servos):
    with driver("feetech", servos) as one:
        info = one.open()
        assert info.settings["servos"].startswith("10 model 777, 11 model 777")
        assert info.dead_man == ""
        assert any("if this computer falls silent" in text for text in info.warnings)
        assert set(info.signals) == {"position", "velocity", "current", "temperature"}


def test_an_alarm_on_which_a_servo_gives_way_is_a_fault_and_another_an_event(mirrors):
    with armed(counting("feetech", mirrors)) as one:
        fresh(one)
        send_only(mirrors, f"error {servo(1)} 1")
        sample, events = until(one, lambda s: s.events)
        assert (sample.fault, events) == ("", ["servo 11 (joint2) warns: voltage"])
        send_only(mirrors, f"error {servo(1)} 33")
        sample, _ = until(one, lambda s: s.fault)
        assert sample.fault == "servo 11 (joint2) gives way: overload"


def test_position_limits_of_the_servos_are_the_window(mirrors):
    send_only(mirrors, "set 9 2 1000")
    send_only(mirrors, "set 11 2 3000")
    with counting("feetech", mirrors) as one:
        info = one.open()
        np.testing.assert_allclose(info.window_upper - info.window_lower, 2000 * TURN)
        one.arm_drives()
        sample, _ = until(one, lambda s: s.fault, hold(np.full(6, 3001 * TURN)))
        assert "count 3001 of its servo, which takes 1000 to 3000" in sample.fault


def test_bridges_that_measure_no_current_are_reported(servos):
    send_only(servos, "set 18 1 32")
    with driver("feetech", servos) as one:
        info = one.open()
        assert "current" not in info.signals
        assert any("measure no current" in text for text in info.warnings)
        assert one._bus.read(GOAL_VELOCITY) == [68] * 6
        assert np.isnan(fresh(one).current).all()
