"""The Feetech driver, against servos that run as a process."""

import numpy as np
import pytest

from exidyn.drivers import Command, StopLevel, create
from exidyn.drivers.errors import BadSettings, NotReady
from exidyn.drivers.feetech.driver import GOAL_VELOCITY

from ...parts.controllers.servo_parts import (
    SETTINGS,
    TURN,
    arm,
    armed,
    counting,
    driver,
    fresh,
    hold,
    module_peer,
    send_only,
    servo,
    still,
    until,
)

moving = module_peer("feetech")
mirroring = module_peer("feetech", "--mirror")


@pytest.fixture
def servos(moving):
    send_only(moving, "heal")
    return moving


@pytest.fixture
def mirrors(mirroring):
    """Servos that are where they were commanded last."""
    send_only(mirroring, "heal")
    return mirroring


def test_servos_are_found_and_nobody_claims_that_they_stop_by_themselves(servos):
    with driver("feetech", servos) as one:
        info = one.open()
        assert info.settings["servos"].startswith("10 model 777, 11 model 777")
        assert info.dead_man == ""
        assert any("if this computer falls silent" in text for text in info.warnings)
        assert set(info.signals) == {"position", "velocity", "current", "temperature"}


def test_the_arm_follows_and_reports_position_velocity_and_current(servos):
    with armed(driver("feetech", servos)) as one:
        start = still(one)
        samples = []
        for number in range(300):
            sweep = 0.1 * (1.0 - np.cos(np.pi * number / 300)) * np.ones(6)
            samples.append(one.exchange(Command(start + sweep, np.zeros(6))))
        until(one, lambda s: np.all(np.abs(s.position - start - 0.2) < 4e-3), hold(start + 0.2))
        assert (np.nanmax([sample.velocity for sample in samples], axis=0) > 0.05).all()
        assert np.nanmax(np.abs([sample.current for sample in samples])) > 0.5
        assert np.nanmin([sample.temperature for sample in samples]) > 10.0


def test_every_fresh_sample_is_of_its_own_cycle_on_both_sides_of_zero(mirrors):
    with armed(counting("feetech", mirrors)) as one:
        checked = 0
        for number in range(-100, 100):
            if number in (-80, 10):
                send_only(mirrors, f"late {0.02 + 1e-4 * (number + 80)} 1")
            if number == 50:
                send_only(mirrors, "short 1")
            sample = one.exchange(hold(np.full(6, number * TURN)))
            checked += not sample.stale.any()
            np.testing.assert_allclose(sample.position[~sample.stale], number * TURN, atol=1e-9)
        assert checked > 50


def test_an_alarm_on_which_a_servo_gives_way_is_a_fault_and_another_an_event(mirrors):
    with armed(counting("feetech", mirrors)) as one:
        fresh(one)
        send_only(mirrors, f"error {servo(1)} 1")
        sample, events = until(one, lambda s: s.events)
        assert (sample.fault, events) == ("", ["servo 11 (joint2) warns: voltage"])
        send_only(mirrors, f"error {servo(1)} 33")
        sample, _ = until(one, lambda s: s.fault)
        assert sample.fault == "servo 11 (joint2) gives way: overload"


def test_a_quick_stop_holds_and_off_switches_torque_off(servos):
    with armed(driver("feetech", servos)) as one:
        start = fresh(one).position
        for number in range(50):
            one.exchange(hold(start + 0.001 * number))
        one.stop(StopLevel.QUICK)
        here = fresh(one).position
        for _ in range(100):
            one.exchange(hold(start + 1.0))
        np.testing.assert_allclose(fresh(one).position, here, atol=0.03)
        one.stop(StopLevel.OFF)
        fresh(one)
        assert one._bus.read(one.torque) == [0] * 6


def test_position_limits_of_the_servos_are_the_window(mirrors):
    send_only(mirrors, "set 9 2 1000")
    send_only(mirrors, "set 11 2 3000")
    with counting("feetech", mirrors) as one:
        info = one.open()
        np.testing.assert_allclose(info.window_upper - info.window_lower, 2000 * TURN)
        one.arm_drives()
        sample, _ = until(one, lambda s: s.fault, hold(np.full(6, 3001 * TURN)))
        assert "count 3001 of its servo, which takes 1000 to 3000" in sample.fault


def test_another_mode_is_refused(servos):
    send_only(servos, "set 33 1 1")
    with driver("feetech", servos) as one:
        with pytest.raises(NotReady, match=r"servo 10 .* operating mode 1, not 0 \(position\)"):
            one.open()


def test_bridges_that_measure_no_current_are_reported(servos):
    send_only(servos, "set 18 1 32")
    with driver("feetech", servos) as one:
        info = one.open()
        assert "current" not in info.signals
        assert any("measure no current" in text for text in info.warnings)
        assert one._bus.read(GOAL_VELOCITY) == [68] * 6
        assert np.isnan(fresh(one).current).all()


def test_an_adapter_that_hears_itself_is_not_taken_for_servos(servos):
    send_only(servos, "echo")
    for place in range(6):
        send_only(servos, f"silent {servo(place)}")
    with driver("feetech", servos) as one, pytest.raises(NotReady, match="the adapter echoes"):
        one.open()


def test_a_line_that_cannot_carry_the_cycle_is_refused():
    with pytest.raises(BadSettings, match="40 bytes out and 126 back at 1000000 bit/s.*cycle of 0.0019 s"):
        create("feetech", SETTINGS["feetech"]("/dev/x") | {"cycle": 0.0015}, arm())
